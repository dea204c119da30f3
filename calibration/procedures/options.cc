#include "calibration/procedures/options.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace caltwin {

CommonOptions ReadCommon(YamlMap* map, const CommonOptions& defaults) {
  CommonOptions options = defaults;
  options.place = map->place();
  if (const auto axis = map->Required("axis")) {
    options.axis = AxisNamed(axis->Word({"x", "y", "z"})).value_or(Axis::kX);
  }
  options.as_published =
      map->WordOr("variant", defaults.Variant(), {"as_published", "corrected"}) ==
      "as_published";
  options.artefact = map->TextOr("artefact", defaults.artefact);
  options.repeats =
      static_cast<int>(map->IntegerOr("repeats", defaults.repeats, 1, 1000));
  options.iterations =
      static_cast<int>(map->IntegerOr("iterations", defaults.iterations, 1, 100));
  options.verify = map->FlagOr("verify", defaults.verify);
  options.rules.apply = map->FlagOr("apply", true);
  options.rules.roll_back = map->FlagOr("rollback", !options.as_published);
  options.rules.keep_within_sd = options.as_published ? 0 : kKeepWithinSd;
  options.rules.steps_limit =
      map->NumberOr("steps_limit", defaults.rules.steps_limit, {1e-4, 0.5});
  return options;
}

std::vector<Axis> ReadAxes(YamlMap* map) {
  std::vector<Axis> axes;
  const auto add = [&](const YamlValue& value) {
    axes.push_back(AxisNamed(value.Word({"x", "y", "z"})).value_or(Axis::kX));
  };
  const auto one = map->Optional("axis");
  const auto several = map->Optional("axes");
  if (one) add(*one);
  if (several) {
    for (const YamlValue& value : several->List()) add(value);
    if (one) several->Fail("stands beside `axis`", "give one of the two");
  }
  if (axes.empty()) axes.assign(kAxes.begin(), kAxes.end());
  return axes;
}

std::vector<double> ReadDimensions(YamlMap* map, const std::vector<double>& otherwise) {
  const auto value = map->Optional("dimensions");
  if (!value) return otherwise;
  std::vector<double> sizes_mm;
  for (const YamlValue& item : value->List()) {
    sizes_mm.push_back(item.Number({0.1, 1000}));
  }
  const bool ascending =
      std::ranges::adjacent_find(sizes_mm, std::greater_equal<>{}) == sizes_mm.end();
  if (sizes_mm.size() < 2 || !ascending) {
    value->Fail("must be two or more sizes in mm, ascending",
                "a 1-2-3 block has 25.4, 50.8 and 76.2");
    return otherwise;
  }
  for (const double size_mm : sizes_mm) {
    const bool is_of_block = std::ranges::any_of(kBlockSizes_mm, [&](double one_mm) {
      return std::abs(one_mm - size_mm) < 1e-6;
    });
    if (is_of_block) continue;
    value->Fail(fmt::format("{:g} is no size of a 1-2-3 block", size_mm),
                "it has 25.4, 50.8 and 76.2 mm");
    return otherwise;
  }
  return sizes_mm;
}

Artefact* SeekArtefact(Bench* bench,
                       const std::string& id,
                       const std::vector<ArtefactType>& types,
                       const Place& place) {
  std::vector<std::string> ids;
  for (Artefact& artefact : bench->artefacts) {
    const bool fits = std::ranges::find(types, artefact.type) != types.end();
    if (fits && (id.empty() || artefact.id == id)) return &artefact;
    if (fits) ids.push_back(artefact.id);
  }
  if (id.empty()) return nullptr;
  throw InputError(
      place,
      fmt::format("there is no artefact '{}' that this procedure can use", id),
      ids.empty() ? "" : fmt::format("It can use: {}", fmt::join(ids, ", ")));
}

Artefact* FindArtefact(Bench* bench,
                       const std::string& id,
                       const std::vector<ArtefactType>& types,
                       const Place& place) {
  Artefact* found = SeekArtefact(bench, id, types, place);
  if (found != nullptr) return found;
  std::vector<std::string> words;
  for (const ArtefactType type : types) words.push_back(ToString(type));
  throw InputError(place,
                   fmt::format("this procedure needs an artefact of type {}",
                               fmt::join(words, " or ")),
                   "add it under `artefacts:`");
}

}  // namespace caltwin

#include "scenarios/machine_file.h"

#include <array>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scenarios/kinds/refusal.h"
#include "sim/base/sha256.h"
#include "sim/base/text_file.h"
#include "sim/effects/catalog.h"
#include "sim/effects/map_table.h"
#include "sim/machine/kinds/kinds.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kLargestModel_bytes = 100'000'000;

struct SettingKey {
  const char* key;
  std::array<double, 3> Settings::*values;
  Bounds bounds;
  bool is_drive = true;  ///< Else of the probe, by axis.
};
constexpr std::array kSettingKeys = {
    SettingKey{"steps_per_mm", &Settings::steps_per_mm, {1e-3, 1e7}},
    SettingKey{"backlash_mm", &Settings::backlash_mm, {0, 10}},
    SettingKey{
        "probe_deflection_mm", &Settings::probe_deflection_mm, {-10, 10}, false}};
constexpr const char* kTipRadius = "tip_radius_mm";
constexpr Bounds kTipRadiusBounds{0, 50};

// The effects of an extension without what only diagnosis reads. Parsed again rather
// than copied, so that the places of the remaining keys stand in messages.
YamlMap PlainEffects(const fs::path& file, Faults* faults) {
  YAML::Node root = YAML::Load(ReadTextFile(file, kLargestFile_bytes));
  YAML::Node effects = root["effects"];
  for (auto entry : effects) {
    if (!entry.second.IsMap()) continue;
    for (const char* key : {"sd", "probability", "rivals"}) entry.second.remove(key);
  }
  return {effects, file.string(), "effects", faults};
}

// Knots of every covariate: a list of lists, or the knots of the only one.
std::vector<std::vector<double>> ReadAllKnots(const YamlValue& value,
                                              std::size_t num_covariates) {
  const std::vector<YamlValue> lists = value.List();
  if (num_covariates == 1 && !lists.empty() && !lists[0].is_list()) {
    return {ReadKnots(value)};
  }
  if (lists.size() != num_covariates) {
    value.Fail("has not one list of knots for each covariate");
    return {};
  }
  std::vector<std::vector<double>> knots;
  for (const YamlValue& list : lists) knots.push_back(ReadKnots(list));
  return knots;
}

std::vector<std::string> ReadCovariates(const YamlValue& value) {
  constexpr std::size_t kMost = 2;
  std::vector<std::string> words;
  for (const YamlValue& word : value.List()) {
    words.push_back(word.Text());
    if (!IsCovariate(words.back())) {
      word.Fail("is no covariate",
                "x y z t temp dir_x dir_y dir_z since_rev feed load theta");
    }
  }
  if (words.empty() || words.size() > kMost) {
    value.Fail("names one or two covariates");
    words.resize(1);
  }
  return words;
}

// One table of `unknown`; `sd`, `probability` and `rivals` are read and dropped. A
// table over its own axis in a motion channel is that axis's unknown, not a pitch map:
// the name is the diagnosis's to give.
std::optional<InjectedSpec> ReadUnknown(YamlMap map) {
  const auto channel = map.Required("channel");
  const auto covariates = map.Required("covariates");
  const auto knots = map.Required("knots");
  const auto values = map.Required("values");
  for (const char* key : {"sd", "probability", "rivals"}) map.Optional(key);
  map.NoMoreKeys();
  if (!channel || !covariates || !knots || !values) return std::nullopt;
  const std::vector<std::string> words = ReadCovariates(*covariates);
  const auto table = ReadAllKnots(*knots, words.size());
  if (table.empty()) return std::nullopt;
  std::size_t cells = 1;
  for (const auto& list : table) cells *= list.size();
  const auto& parameter = UnknownMap::kParameters[0];
  const auto flat =
      FlatMap(values->Numbers(cells, {parameter.min, parameter.max}), table);
  return InjectedSpec{
      .effect = EffectIndex<UnknownMap>(),
      .axis =
          MapAxis(channel->Word(
                      {"x", "y", "z", "a", "b", "c", "z1", "z2", "z3", "probe", "bed"}),
                  words),
      .values = {flat.begin(), flat.end()},
      .place = channel->place()};
}

// What the file that is extended was when diagnosis extended it, and is now.
void CheckBase(const fs::path& file,
               const fs::path& base,
               const std::string& sha256,
               MachineFile* extension) {
  if (sha256.empty() || sha256 == Sha256(ReadTextFile(base, kLargestFile_bytes)))
    return;
  extension->notes.push_back(
      fmt::format("{}: {} has changed since it was extended (its SHA-256 is another); "
                  "diagnose again",
                  file.string(),
                  base.string()));
}

MachineFile ReadExtension(const fs::path& file, YamlMap* map) {
  const auto base = map->Required("extends");
  const fs::path base_file =
      FindMachine(base->Text(), file.parent_path(), base->place());
  MachineFile extension = ReadMachineWithTip(base_file);
  extension.machine.file = file;
  map->IntegerOr("format", 1, 1, 1);
  extension.machine.name = map->TextOr("name", extension.machine.name);
  CheckBase(file, base_file, map->TextOr("extends_sha256", ""), &extension);
  map->Optional("evidence");
  if (const auto baseline = map->Optional("baseline"); baseline && baseline->is_map()) {
    YamlMap lines = baseline->Map();
    for (const auto& [name, value] : lines.Entries()) {
      extension.baseline[name] = value.Number({-1e9, 1e9});
    }
  }
  if (map->Has("effects") && map->Optional("effects")->is_map()) {
    const auto more = ReadEffects(PlainEffects(file, map->faults()), extension.machine);
    extension.effects.insert(extension.effects.end(), more.begin(), more.end());
  } else if (const auto effects = map->Optional("effects")) {
    effects->Map();
  }
  if (const auto unknown = map->Optional("unknown"); unknown && !unknown->is_null()) {
    for (const YamlValue& entry : unknown->List()) {
      if (const auto spec = ReadUnknown(entry.Map())) {
        extension.effects.push_back(*spec);
      }
    }
  }
  map->NoMoreKeys();
  return extension;
}

}  // namespace

MachineFile ReadMachineFile(const fs::path& file) {
  MachineFile read = ReadMachineWithTip(file);
  RequireGantry(read.machine, file);
  return read;
}

MachineFile ReadMachineWithTip(const fs::path& file) {
  MachineFile read = ReadAnyMachineFile(file);
  if (read.machine.kind->has_tip()) return read;
  Faults faults;
  const YamlValue kinematics = *ReadYamlFile(file, &faults).Optional("kinematics");
  std::vector<std::string> names;
  for (const MachineKind* kind : AllMachineKinds()) {
    if (kind->has_tip()) names.emplace_back(kind->name());
  }
  throw InputError(
      kinematics.place(),
      fmt::format("kinematics = {}: single motors, which have no tip to measure or to "
                  "move",
                  read.machine.kind->name()),
      fmt::format("`caltwin run` runs their scenarios, scenarios/motor_*.yaml; here a "
                  "machine is one of {}",
                  fmt::join(names, ", ")));
}

MachineFile ReadAnyMachineFile(const fs::path& file) {
  Faults faults;
  YamlMap map = ReadYamlFile(file, &faults);
  MachineFile read;
  if (map.Has("extends")) {
    read = ReadExtension(file, &map);
  } else {
    read.machine = ReadMachine(&map);
    if (faults.empty() && !read.machine.model.empty()) {
      read.verbatim = ReadTextFile(read.machine.model, kLargestModel_bytes);
    }
  }
  faults.ThrowIfAny();
  read.draws = faults.notes();
  read.verbatim += ReadTextFile(file, kLargestFile_bytes);
  return read;
}

std::vector<SettingSpec> ReadSettingSpecs(YamlMap map, const MachineKind& kind) {
  std::vector<SettingSpec> specs;
  for (const SettingKey& setting : kSettingKeys) {
    const auto value = map.Optional(setting.key);
    if (!value) continue;
    const DriveMap* drives = setting.is_drive ? kind.drive_map() : nullptr;
    YamlMap by_axis = value->Map();
    for (const Axis axis : kAxes) {
      if (const auto number = by_axis.Optional(DriveName(drives, Index(axis)))) {
        specs.push_back({.key = setting.key,
                         .axis = axis,
                         .value = number->NumberOrDistribution(setting.bounds)});
      }
    }
    by_axis.NoMoreKeys();
  }
  if (const auto radius = map.Optional(kTipRadius)) {
    specs.push_back(
        {.key = kTipRadius, .value = radius->NumberOrDistribution(kTipRadiusBounds)});
  }
  map.NoMoreKeys();
  return specs;
}

Settings DrawSettings(Settings settings,
                      const std::vector<SettingSpec>& specs,
                      std::uint64_t seed,
                      std::uint64_t sample) {
  for (const SettingSpec& spec : specs) {
    Rng rng(seed,
            sample,
            fmt::format("settings.{}.{}", spec.key, spec.axis ? Name(*spec.axis) : ""));
    const double value = Draw(spec.value, &rng);
    if (!spec.axis) {
      settings.tip_radius_mm =
          std::clamp(value, kTipRadiusBounds.min, kTipRadiusBounds.max);
      continue;
    }
    for (const SettingKey& setting : kSettingKeys) {
      if (spec.key != setting.key) continue;
      (settings.*setting.values)[Index(*spec.axis)] =
          std::clamp(value, setting.bounds.min, setting.bounds.max);
    }
  }
  return settings;
}

TruthFile ReadTruthFile(const fs::path& file, const Machine& machine) {
  Faults faults;
  YamlMap map = ReadYamlFile(file, &faults);
  TruthFile truth;
  if (const auto effects = map.Optional("effects")) {
    truth.effects = ReadEffects(effects->Map(), machine);
  }
  if (const auto settings = map.Optional("settings")) {
    truth.settings = ReadSettingSpecs(settings->Map(), *machine.kind);
  }
  map.NoMoreKeys();
  faults.ThrowIfAny();
  return truth;
}

}  // namespace caltwin

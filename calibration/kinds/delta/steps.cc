#include "calibration/kinds/delta/steps.h"

#include <algorithm>
#include <cctype>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/link/gcode.h"
#include "sim/machine/kinds/delta/knobs.h"

namespace caltwin {
namespace {

char Capital(char letter) {
  return static_cast<char>(std::toupper(static_cast<unsigned char>(letter)));
}

// Those that a scenario gives, small letters for keys.
std::string ReadG33Letters(YamlMap* map) {
  struct Letter {
    const char* key;
    Bounds bounds;
  };
  constexpr std::array kNumbers = {Letter{"c", {0, 1}},
                                   Letter{"f", {0, 30}},
                                   Letter{"r", {0, 1000}},
                                   Letter{"v", {0, 3}}};
  std::string words;
  for (const Letter& letter : kNumbers) {
    if (const auto value = map->Optional(letter.key)) {
      words += fmt::format(
          " {}{}", Capital(*letter.key), GcodeNumber(value->Number(letter.bounds)));
    }
  }
  for (const char* key : {"e", "o", "t"}) {
    const auto value = map->Optional(key);
    if (value && value->Flag()) words += fmt::format(" {}", Capital(*key));
  }
  return words;
}

std::vector<std::string> KnobNames() {
  std::vector<std::string> names;
  for (const DeltaKnob& knob : kDeltaKnobs) names.emplace_back(knob.name);
  return names;
}

// `fit: [NAME, ...]`; none where a name is wrong.
std::vector<int> ReadFit(const YamlValue& list) {
  std::vector<int> knobs;
  for (const YamlValue& item : list.List()) {
    const std::string name = item.Text();
    const auto knob = DeltaKnobNamed(name);
    if (!knob) {
      const std::vector<std::string> all = KnobNames();
      const std::string nearest = NearestWord(name, all);
      item.Fail(fmt::format("'{}' is no unknown of a delta", name),
                nearest.empty() ? fmt::format("one of {}", fmt::join(all, " "))
                                : fmt::format("did you mean '{}'?", nearest));
    } else if (std::ranges::find(knobs, *knob) != knobs.end()) {
      item.Fail(fmt::format("'{}' stands twice", name));
    } else {
      knobs.push_back(*knob);
    }
  }
  if (list.is_list() && knobs.empty() && list.faults()->empty()) {
    list.Fail("is empty", "name at least one unknown, delta_radius for example");
  }
  return knobs;
}

void ReadPriors(const YamlValue& priors, DeltaStep* step) {
  constexpr Bounds kSd{1e-6, 1e6};
  for (const auto& [name, value] : priors.Map().Entries()) {
    YamlMap keys = value.Map();
    DeltaPrior prior{.sd = keys.Number("sd", kSd, "a standard deviation, above 0")};
    if (const auto is = keys.Optional("value")) prior.value = is->Number();
    keys.NoMoreKeys();
    const auto knob = DeltaKnobNamed(name);
    if (!knob || std::ranges::find(step->knobs, *knob) == step->knobs.end()) {
      std::vector<std::string> fitted;
      for (const int one : step->knobs) {
        fitted.emplace_back(kDeltaKnobs[static_cast<std::size_t>(one)].name);
      }
      value.Fail(fmt::format("'{}' is not among the unknowns of this step", name),
                 fmt::format("it fits {}", fmt::join(fitted, " ")));
      continue;
    }
    prior.knob = *knob;
    step->priors.push_back(prior);
  }
}

// Which numbers a joint estimate asks for, and what is known of them.
void ReadUnknowns(YamlMap* map, DeltaStep* step) {
  const auto unknowns = map->Optional("unknowns");
  step->knobs = unknowns && unknowns->Word({"firmware", "machine"}) == "machine"
                    ? MachineKnobs()
                    : FirmwareKnobs();
  if (const auto fit = map->Optional("fit")) {
    if (unknowns)
      fit->Fail("stands beside 'unknowns'", "one of them says what is fitted");
    step->knobs = ReadFit(*fit);
  }
  if (const auto priors = map->Optional("priors")) ReadPriors(*priors, step);
}

}  // namespace

DeltaStep ReadDeltaStep(const std::string& name, YamlMap* map) {
  DeltaStep step{.name = name};
  if (name == "g33") {
    step.variant = map->WordOr("variant", "corrected", {"as_published", "corrected"});
    step.points = static_cast<int>(map->IntegerOr("p", 4, 0, 10));
    if (const auto r = map->Optional("r")) step.reduced_mm = r->Number({0, 1000});
    step.words = ReadG33Letters(map);
  }
  if (name == "rrf_least_squares") {
    step.factors = static_cast<int>(map->IntegerOr("factors", 6, 3, 9));
    if (step.factors == 5) {
      map->faults()->Add(
          map->place(), "factors: 5 is not known", "there are 3, 4, 6, 7, 8 and 9");
    }
  }
  if (name == "delta_joint") {
    step.points = static_cast<int>(map->IntegerOr("points", 37, 8, 400));
    ReadUnknowns(map, &step);
    step.reads_rods = map->FlagOr("rods", false);
    step.makes_mesh = map->FlagOr("mesh", false);
  }
  if (name == "delta_joint" || name == "klipper_descent") {
    step.reads_print = map->FlagOr("print", false);
  }
  map->NoMoreKeys();
  return step;
}

}  // namespace caltwin

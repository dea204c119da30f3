#include "scenarios/delta_scenario.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scenarios/named_step.h"
#include "sim/effects/catalog.h"
#include "sim/link/gcode.h"
#include "sim/machine/delta_knobs.h"

namespace caltwin {
namespace {

constexpr double kMilli = 1e-3;  // um.

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

DeltaStep ReadDeltaStep(const std::string& name, const YamlValue& options) {
  DeltaStep step{.name = name};
  // An empty value means all options left out.
  YamlMap map = options.is_null() ? YamlMap(YAML::Node(YAML::NodeType::Map),
                                            options.file(),
                                            options.path(),
                                            options.faults())
                                  : options.Map();
  if (name == "g33") {
    step.variant = map.WordOr("variant", "corrected", {"as_published", "corrected"});
    step.points = static_cast<int>(map.IntegerOr("p", 4, 0, 10));
    if (const auto r = map.Optional("r")) step.reduced_mm = r->Number({0, 1000});
    step.words = ReadG33Letters(&map);
  }
  if (name == "rrf_least_squares") {
    step.factors = static_cast<int>(map.IntegerOr("factors", 6, 3, 9));
    if (step.factors == 5) {
      map.faults()->Add(
          map.place(), "factors: 5 is not known", "there are 3, 4, 6, 7, 8 and 9");
    }
  }
  if (name == "delta_joint") {
    step.points = static_cast<int>(map.IntegerOr("points", 37, 8, 400));
    ReadUnknowns(&map, &step);
    step.reads_rods = map.FlagOr("rods", false);
    step.makes_mesh = map.FlagOr("mesh", false);
  }
  if (name == "delta_joint" || name == "klipper_descent") {
    step.reads_print = map.FlagOr("print", false);
  }
  map.NoMoreKeys();
  return step;
}

void ReadDeltaExpectation(YamlMap map, DeltaScenario* scenario) {
  scenario->outcome = map.WordOr(
      "outcome", "recovers", {"recovers", "misses", "diverges", "no_trigger"});
  for (const char* figure : {"height_error_mm.rms",
                             "height_error_mm.most",
                             "height_drift_mm",
                             "height_reversal_mm",
                             "position_error_mm.p95",
                             "xy_scale_um_per_mm",
                             "said_mm"}) {
    if (const auto value = map.Optional(figure)) {
      YamlMap bounds = value->Map();
      Within within;
      if (const auto above = bounds.Optional("above")) within.above = above->Number();
      if (const auto below = bounds.Optional("below")) within.below = below->Number();
      bounds.NoMoreKeys();
      scenario->figures.emplace_back(figure, within);
    }
  }
  if (const auto messages = map.Optional("messages")) {
    for (const YamlValue& text : messages->List()) {
      scenario->messages.push_back(text.Text());
    }
  }
  for (const DeltaKnob& knob : kDeltaKnobs) {
    const auto value = map.Optional(std::string(knob.name));
    if (!value) continue;
    YamlMap keys = value->Map();
    DeltaExpectedValue expected{.name = std::string(knob.name)};
    if (const auto within = keys.Optional("truth_within")) {
      expected.truth_within = within->Number(kNotNegative);
    }
    if (const auto flag = keys.Optional("identifiable")) {
      expected.identifiable = flag->Flag();
    }
    keys.NoMoreKeys();
    scenario->values.push_back(std::move(expected));
  }
  map.NoMoreKeys();
}

void ReadProbeOffset(const YamlValue& value, Vec3<double>* offset_mm) {
  const std::vector<YamlValue> numbers = value.List();
  if (numbers.size() != 3) {
    value.Fail("is not three numbers", "M851 X Y Z: of the tip from the nozzle");
    return;
  }
  for (int i = 0; i < 3; ++i) {
    const double most_mm = i == 2 ? 20 : 50;  // As Marlin has it.
    (*offset_mm)[i] = numbers[static_cast<std::size_t>(i)].Number({-most_mm, most_mm});
  }
}

// Whether the twin that firmware drives can be built with it.
void RequireBuildable(const InjectedSpec& spec, Faults* faults) {
  const Effect& effect = EffectAt(spec.effect);
  const std::vector<double> any(effect.parameters.size(), 1);
  const bool is_part =
      !TurnsOf({.effect = spec.effect, .axis = spec.axis, .values = any}).empty();
  if (is_part || spec.effect == EffectIndex<CarriageBacklash>()) return;
  faults->Add(spec.place,
              fmt::format("'{}' is no part of a delta that firmware can calibrate here",
                          effect.name),
              "`caltwin simulate --truth` has drives, heat and probe");
}

}  // namespace

std::vector<DeltaStep> ReadDeltaSteps(const YamlValue& list) {
  constexpr std::array<std::string_view, 4> kNames = {
      "g33", "rrf_least_squares", "klipper_descent", "delta_joint"};
  std::vector<DeltaStep> steps;
  for (const NamedStep& step : ReadNamedSteps(list, kNames, "procedure of a delta")) {
    steps.push_back(ReadDeltaStep(step.name, step.options));
  }
  return steps;
}

void RequireDeltaParts(const DeltaEffects& effects, Faults* faults) {
  for (const InjectedSpec& effect : effects.effects) RequireBuildable(effect, faults);
}

DeltaScenario ReadDeltaScenario(YamlMap* map,
                                const Machine& machine,
                                const std::vector<InjectedSpec>& machine_effects) {
  DeltaScenario scenario{.settings = machine.delta->settings};
  if (const auto effects = map->Optional("effects")) {
    scenario.effects = ReadDeltaEffects(effects->Map(), machine);
  }
  std::vector<InjectedSpec>& all = scenario.effects.effects;
  all.insert(all.end(), machine_effects.begin(), machine_effects.end());
  RequireDeltaParts(scenario.effects, map->faults());
  if (const auto settings = map->Optional("settings")) {
    YamlMap keys = settings->Map();
    ReadDeltaSettings(&keys, machine.delta->model, &scenario.settings);
    if (const auto offset = keys.Optional("probe_offset_mm")) {
      ReadProbeOffset(*offset, &scenario.probe_offset_mm);
    }
    keys.NoMoreKeys();
  }
  if (const auto instruments = map->Optional("instruments")) {
    YamlMap by_name = instruments->Map();
    if (const auto probe = by_name.Optional("probe")) {
      YamlMap keys = probe->Map();
      scenario.probe_sigma_mm = kMilli * keys.NumberOr("sigma_um", 0, {0, 1000});
      keys.NoMoreKeys();
    }
    if (const auto calliper = by_name.Optional("calliper")) {
      YamlMap keys = calliper->Map();
      scenario.calliper_sigma_mm = kMilli * keys.NumberOr("sigma_um", 20, {0, 1000});
      keys.NoMoreKeys();
    }
    by_name.NoMoreKeys();
  }
  if (const auto calibrate = map->Required("calibrate")) {
    scenario.calibrate = ReadDeltaSteps(*calibrate);
    const double most_mm = machine.delta->print_radius_mm;
    for (const DeltaStep& step : scenario.calibrate) {
      if (step.reduced_mm < most_mm) continue;
      calibrate->Fail(fmt::format("g33's r is {:g} mm, and the bed's radius {:g}: no "
                                  "disc is left to touch",
                                  step.reduced_mm,
                                  most_mm),
                      "r is taken off the radius");
    }
  }
  if (const auto expect = map->Optional("expect")) {
    ReadDeltaExpectation(expect->Map(), &scenario);
  }
  return scenario;
}

BuiltDelta DrawDelta(const DeltaScenario& scenario,
                     const Machine& machine,
                     std::uint64_t seed,
                     std::uint64_t sample) {
  auto [built, others] = DrawDelta(scenario.effects, machine, seed, sample);
  BuildPlayIn(&others, &built);
  built.scatter_mm = std::hypot(built.scatter_mm, scenario.probe_sigma_mm);
  return built;
}

}  // namespace caltwin

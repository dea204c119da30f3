#include "scenarios/kinds/triple_z_scenario.h"

#include <array>

#include <fmt/format.h>

#include "scenarios/kinds/gantry_scenario.h"
#include "scenarios/kinds/triple_z_trial.h"
#include "scenarios/named_step.h"
#include "sim/base/units.h"
#include "sim/effects/catalog.h"
#include "sim/machine/kinds/triple_z/drawing.h"

namespace caltwin {
namespace {

constexpr std::array<std::string_view, 6> kProcedures = {"plane_tilt",
                                                         "bed_tilt",
                                                         "bed_tilt_iterated",
                                                         "rrf_levelling",
                                                         "pivots_and_wiring",
                                                         "move_triple_z"};
constexpr std::array<const char*, 7> kFigures = {"level_error_mm.mean",
                                                 "level_error_mm.max",
                                                 "flatness_mm.rms",
                                                 "validation_mm.mean",
                                                 "hold_out_mm.mean",
                                                 "position_error_mm.p95",
                                                 "predicted_factor"};

// An empty value means all options left out.
YamlMap MapOf(const YamlValue& options) {
  if (!options.is_null()) return options.Map();
  return {YAML::Node(YAML::NodeType::Map),
          options.file(),
          options.path(),
          options.faults()};
}

void ReadGrid(YamlMap* map, TripleZOptions* options) {
  const auto grid = map->Optional("grid");
  if (!grid) return;
  const auto numbers = grid->Numbers(2, {2, 20});
  if (numbers.size() != 2) return;
  options->columns = static_cast<int>(numbers[0]);
  options->rows = static_cast<int>(numbers[1]);
  if (numbers[0] != options->columns || numbers[1] != options->rows) {
    grid->Fail("is no pair of whole numbers", "as in `grid: [3, 3]`");
  }
  if (options->at_screws && !options->holds_out) {
    grid->Fail("is not touched with `at: screws`", "leave one of them out");
  }
}

// Where the bed is touched; for pivots always three by three.
void ReadProbing(const std::string& name, YamlMap* map, TripleZOptions* options) {
  options->margin_mm = map->NumberOr("margin_mm", options->margin_mm, {0, 100});
  if (name == "pivots_and_wiring") return;
  if (const auto at = map->Optional("at")) {
    options->at_screws = at->Word({"grid", "screws"}) == "screws";
  }
  const auto hold_out = map->Optional("hold_out");
  options->holds_out = hold_out && hold_out->Flag();
  ReadGrid(map, options);
}

void ReadLevelling(YamlMap* map, TripleZOptions* options) {
  options->reference_mm = map->NumberOr("reference_mm", 0, {-50, 250});
  if (options->is_as_published) {
    const std::string sign = map->WordOr("offsets", "example", {"example", "formula"});
    options->rule = sign == "formula" ? OffsetRule::kFormula : OffsetRule::kExample;
  }
  options->largest_mm = map->NumberOr("largest_mm", options->largest_mm, {0, 250});
}

void ReadRounds(YamlMap* map, int otherwise, TripleZOptions* options) {
  options->rounds = static_cast<int>(map->IntegerOr("rounds", otherwise, 1, 50));
  options->target_mm = map->NumberOr("target_mm", options->target_mm, {0, 10});
}

// move_triple_z: {at_mm: [x, y], heights_mm: [z1, z2, z3]}. The printer itself bounds
// heights.
void ReadMove(YamlMap* map, TripleZStep* step) {
  const auto at = map->Required("at_mm");
  const auto heights = map->Required("heights_mm");
  const auto at_mm = at ? at->Numbers(2, {-1e4, 1e4}) : std::vector<double>{};
  const auto heights_mm =
      heights ? heights->Numbers(3, {-1e4, 1e4}) : std::vector<double>{};
  if (at_mm.size() != 2 || heights_mm.size() != 3) return;
  step->at_mm = {at_mm[0], at_mm[1]};
  step->heights_mm = {heights_mm[0], heights_mm[1], heights_mm[2]};
}

std::vector<std::string> ValueNames() {
  std::vector<std::string> names = {"bed_tilt.slope_x_mrad", "bed_tilt.slope_y_mrad"};
  for (const std::string_view screw : kScrewAxes) {
    for (const char* along : {"dx_mm", "dy_mm"}) {
      names.push_back(fmt::format("pivot_position.{}.{}", screw, along));
    }
  }
  for (const std::string_view wiring : MotorsSwapped::kWirings) {
    names.push_back(fmt::format("motors_swapped.{}", wiring));
  }
  return names;
}

void ReadSettings(YamlMap map, TripleZScenario* scenario) {
  if (const auto screws = map.Optional("screws_at_mm")) {
    YamlMap by_name = screws->Map();
    for (int i = 0; i < kNumScrews; ++i) {
      const auto at = by_name.Optional(ScrewName(i));
      if (!at) continue;
      const auto numbers = at->Numbers(2, {-1e4, 1e4});
      if (numbers.size() != 2) continue;
      scenario->believed_mm[static_cast<std::size_t>(i)] = {numbers[0], numbers[1]};
    }
    by_name.NoMoreKeys();
    if (TriangleShape(scenario->believed_mm) < kFlattestTriangle) {
      screws->Fail("stand nearly in one line", "three screws span a triangle");
    }
  }
  if (const auto steps = map.Optional("steps_per_mm")) {
    YamlMap by_axis = steps->Map();
    scenario->steps_per_mm = by_axis.NumberOr("z", scenario->steps_per_mm, {1e-3, 1e7});
    by_axis.NoMoreKeys();
  }
  map.NoMoreKeys();
}

void RequireBuildable(const InjectedSpec& spec, Faults* faults) {
  const Effect& effect = EffectAt(spec.effect);
  if (effect.bucket != Bucket::kTime && effect.name != "probe_temperature") return;
  faults->Add(spec.place,
              fmt::format("'{}' needs times or temperatures, which no scenario of a "
                          "triple-Z printer has",
                          effect.name),
              "`caltwin simulate --truth` has them");
}

TripleZStep ReadTripleZStep(const std::string& name, const YamlValue& value) {
  TripleZStep step{.name = name};
  YamlMap map = MapOf(value);
  if (name == "move_triple_z") {
    ReadMove(&map, &step);
    map.NoMoreKeys();
    return step;
  }
  TripleZOptions& o = step.options;
  o.is_as_published =
      map.WordOr("variant", "corrected", {"as_published", "corrected"}) ==
      "as_published";
  const bool finds_pivots = name == "pivots_and_wiring";
  if (finds_pivots) {
    o.from_rounds =
        map.WordOr("from", "single_screws", {"single_screws", "rounds"}) == "rounds";
  }
  ReadProbing(name, &map, &o);
  if (finds_pivots && o.from_rounds) {
    o.largest_mm = map.NumberOr("largest_mm", o.largest_mm, {0, 250});
  }
  if (name == "bed_tilt" || name == "bed_tilt_iterated") ReadLevelling(&map, &o);
  if (name == "plane_tilt")
    o.reference_mm = map.NumberOr("reference_mm", 0, {-50, 250});
  o.iterates = name == "bed_tilt_iterated";
  if (o.iterates) ReadRounds(&map, 5, &o);
  if (name == "rrf_levelling") ReadRounds(&map, 2, &o);
  const bool foretells = (o.iterates || name == "rrf_levelling") && !o.is_as_published;
  if (foretells || (finds_pivots && !o.from_rounds)) {
    // To tell wiring half a millimetre does, to tell places more is better.
    o.test_mm = map.NumberOr("test_mm", finds_pivots ? 2 : 0.5, {0.01, 10});
  }
  map.NoMoreKeys();
  return step;
}

}  // namespace

std::vector<TripleZStep> ReadTripleZSteps(const YamlValue& list) {
  std::vector<TripleZStep> steps;
  for (const NamedStep& step :
       ReadNamedSteps(list, kProcedures, "procedure of a triple-Z printer")) {
    steps.push_back(ReadTripleZStep(step.name, step.options));
  }
  return steps;
}

void TripleZScenario::ReadKeys(YamlMap* map, Scenario* scenario) {
  const Machine& machine = scenario->machine.machine;
  effects = scenario->machine.effects;
  believed_mm = TripleZOf(machine).pivots_mm();
  steps_per_mm = machine.settings.steps_per_mm[2];
  if (const auto value = map->Optional("effects")) {
    const auto read = ReadEffects(value->Map(), machine);
    effects.insert(effects.end(), read.begin(), read.end());
  }
  for (const InjectedSpec& effect : effects) RequireBuildable(effect, map->faults());
  if (const auto value = map->Optional("settings")) ReadSettings(value->Map(), this);
  if (const auto value = map->Optional("instruments")) {
    YamlMap by_name = value->Map();
    if (const auto probe = by_name.Optional("probe")) {
      YamlMap keys = probe->Map();
      probe_sigma_mm = MmFromUm(keys.NumberOr("sigma_um", 0, {0, 1000}));
      keys.NoMoreKeys();
    }
    by_name.NoMoreKeys();
  }
}

std::vector<std::string> TripleZScenario::StepNames() const {
  return {kProcedures.begin(), kProcedures.end()};
}

CalibrationStep TripleZScenario::ReadStep(const std::string& name,
                                          const YamlValue& options,
                                          const std::string& /*usual_axis*/) const {
  const TripleZStep step = ReadTripleZStep(name, options);
  return {.name = name, .perform = [step](KindTrial* trial) {
            return dynamic_cast<TripleZTrial&>(*trial).Take(step);
          }};
}

void TripleZScenario::RefuseStep(const std::string& name,
                                 const YamlValue& options) const {
  RefuseNamedStep(name, options, kProcedures, "procedure of a triple-Z printer");
}

Expectable TripleZScenario::CanExpect() const {
  return {.parameters = ValueNames(), .figures = {kFigures.begin(), kFigures.end()}};
}

std::vector<std::string> TripleZScenario::EffectNames() const {
  std::vector<std::string> names;
  for (const Effect* effect : AllEffects()) names.emplace_back(effect->name);
  return names;
}

void TripleZScenario::Vary(const std::string& effect,
                           const std::string& parameter,
                           const YamlValue& value,
                           Scenario* scenario) {
  VaryEffects(effect, parameter, value, scenario->machine.machine, &effects);
}

std::unique_ptr<KindTrial> TripleZScenario::Begin(const Scenario& scenario,
                                                  const Chance& chance) const {
  return std::make_unique<TripleZTrial>(*this, scenario.machine.machine, chance);
}

BuiltTripleZ DrawTripleZ(const TripleZScenario& scenario,
                         const Machine& machine,
                         std::uint64_t seed,
                         std::uint64_t sample) {
  BuiltTripleZ built{.machine = machine,
                     .effects = DrawEffects(scenario.effects, seed, sample),
                     .scatter_mm = scenario.probe_sigma_mm};
  built.machine.settings.steps_per_mm[2] = scenario.steps_per_mm;
  return built;
}

}  // namespace caltwin

#include "scenarios/kinds/triple_z_scenario.h"

#include <array>

#include <fmt/format.h>

#include "scenarios/kinds/gantry_scenario.h"
#include "scenarios/kinds/triple_z_klipper_trial.h"
#include "scenarios/kinds/triple_z_trial.h"
#include "sim/base/units.h"
#include "sim/effects/catalog.h"
#include "sim/machine/kinds/triple_z/drawing.h"

namespace caltwin {
namespace {

constexpr std::array<const char*, 7> kFigures = {"level_error_mm.mean",
                                                 "level_error_mm.max",
                                                 "flatness_mm.rms",
                                                 "validation_mm.mean",
                                                 "hold_out_mm.mean",
                                                 "position_error_mm.p95",
                                                 "predicted_factor"};

/// Where move_triple_z goes to: the nozzle, and the screws.
struct Move {
  Eigen::Vector2d at_mm = Eigen::Vector2d::Zero();
  Vec3<double> heights_mm = Vec3<double>::Zero();
};

// move_triple_z: {at_mm: [x, y], heights_mm: [z1, z2, z3]}. The printer itself bounds
// heights.
Move ReadMove(YamlMap* map) {
  Move move;
  const auto at = map->Required("at_mm");
  const auto heights = map->Required("heights_mm");
  const auto at_mm = at ? at->Numbers(2, {-1e4, 1e4}) : std::vector<double>{};
  const auto heights_mm =
      heights ? heights->Numbers(3, {-1e4, 1e4}) : std::vector<double>{};
  map->NoMoreKeys();
  if (at_mm.size() != 2 || heights_mm.size() != 3) return move;
  move.at_mm = {at_mm[0], at_mm[1]};
  move.heights_mm = {heights_mm[0], heights_mm[1], heights_mm[2]};
  return move;
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

}  // namespace

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
  if (const auto value = map->Optional("firmware")) {
    YamlMap keys = value->Map();
    probe = ReadProbeInput(&keys);
    if (const auto still = keys.Optional("still_alone")) {
      const std::string word = still->Word({"z1", "z2", "z3"});
      for (int i = 0; i < kNumScrews; ++i) {
        if (word == ScrewName(i)) still_alone = i;
      }
    }
    keys.NoMoreKeys();
  }
  if (const auto value = map->Optional("instruments")) {
    YamlMap by_name = value->Map();
    if (const auto instrument = by_name.Optional("probe")) {
      YamlMap keys = instrument->Map();
      probe_sigma_mm = MmFromUm(keys.NumberOr("sigma_um", 0, {0, 1000}));
      keys.NoMoreKeys();
    }
    by_name.NoMoreKeys();
  }
}

std::vector<Word> TripleZScenario::ScenarioSteps() const {
  return {
      Word{"move_triple_z",
           "A step: the nozzle to at_mm [x, y], the screws to heights_mm [z1, z2, z3], "
           "0 "
           "to the top each; homes if needed, waits. What lies outside is refused and "
           "nothing moves."}};
}

CalibrationStep TripleZScenario::ReadScenarioStep(const std::string& name,
                                                  YamlMap options) const {
  const Move move = ReadMove(&options);
  return {.name = name, .procedure = [name, move](Bench* bench) {
            ProcedureResult result;
            const auto moved = bench->kept.Find<TripleZPrinter>()->MoveTripleZ(
                move.at_mm[0], move.at_mm[1], move.heights_mm);
            if (moved) return result;
            result.fault = moved.error().reply;
            result.ending = EndingOfFault(moved.error());
            result.messages.push_back(MachineSaid(result.fault));
            return result;
          }};
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

std::unique_ptr<KindTrial> TripleZScenario::BeginUnderKlipper(
    const Scenario& scenario, const Chance& chance) const {
  return BeginTripleZUnderKlipper(*this, scenario, chance);
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

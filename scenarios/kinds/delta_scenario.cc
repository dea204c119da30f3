#include "scenarios/kinds/delta_scenario.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "scenarios/kinds/delta_klipper_trial.h"
#include "scenarios/kinds/delta_linuxcnc_trial.h"
#include "scenarios/kinds/delta_trial.h"
#include "scenarios/kinds/gantry_scenario.h"
#include "sim/effects/catalog.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/delta/knobs.h"

namespace caltwin {
namespace {

constexpr double kMilli = 1e-3;  // um.

constexpr std::array kFigures = {"height_error_mm.rms",
                                 "height_error_mm.most",
                                 "height_drift_mm",
                                 "height_reversal_mm",
                                 "position_error_mm.p95",
                                 "position_error_mm.rms",
                                 "position_error_mm.most",
                                 "zero_shift_mm",
                                 "xy_scale_um_per_mm",
                                 "said_mm"};

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

void RequireDeltaParts(const DeltaEffects& effects, Faults* faults) {
  for (const InjectedSpec& effect : effects.effects) RequireBuildable(effect, faults);
}

void DeltaScenario::ReadKeys(YamlMap* map, Scenario* scenario) {
  const Machine& machine = scenario->machine.machine;
  settings = DeltaOf(machine).settings;
  print_radius_mm = DeltaOf(machine).print_radius_mm;
  if (const auto value = map->Optional("effects")) {
    effects = ReadDeltaEffects(value->Map(), machine);
  }
  std::vector<InjectedSpec>& all = effects.effects;
  const std::vector<InjectedSpec>& of_machine = scenario->machine.effects;
  all.insert(all.end(), of_machine.begin(), of_machine.end());
  RequireDeltaParts(effects, map->faults());
  if (const auto value = map->Optional("settings")) {
    YamlMap keys = value->Map();
    ReadDeltaSettings(&keys, DeltaOf(machine).model, &settings);
    if (const auto offset = keys.Optional("probe_offset_mm")) {
      ReadProbeOffset(*offset, &probe_offset_mm);
    }
    keys.NoMoreKeys();
  }
  if (const auto instruments = map->Optional("instruments")) {
    YamlMap by_name = instruments->Map();
    if (const auto probe = by_name.Optional("probe")) {
      YamlMap keys = probe->Map();
      probe_sigma_mm = kMilli * keys.NumberOr("sigma_um", 0, {0, 1000});
      keys.NoMoreKeys();
    }
    if (const auto calliper = by_name.Optional("calliper")) {
      YamlMap keys = calliper->Map();
      calliper_sigma_mm = kMilli * keys.NumberOr("sigma_um", 20, {0, 1000});
      keys.NoMoreKeys();
    }
    by_name.NoMoreKeys();
  }
}

Expectable DeltaScenario::CanExpect() const {
  Expectable expectable{.figures = {kFigures.begin(), kFigures.end()}};
  for (const DeltaKnob& knob : kDeltaKnobs) {
    expectable.parameters.emplace_back(knob.name);
  }
  return expectable;
}

void DeltaScenario::Vary(const std::string& effect,
                         const std::string& parameter,
                         const YamlValue& value,
                         Scenario* scenario) {
  const DeltaEffects varied =
      ReadDeltaEffects(value.Within(effect, parameter), scenario->machine.machine);
  for (const DeltaInjected& part : varied.parts) {
    std::erase_if(effects.parts, [&](const DeltaInjected& had) {
      return had.name == part.name && had.parameter == part.parameter;
    });
    effects.parts.push_back(part);
  }
  for (const InjectedSpec& spec : varied.effects) {
    ReplaceEffect(spec, parameter, &effects.effects);
  }
}

std::vector<std::string> DeltaScenario::PersonsActs() const {
  std::vector<std::string> acts = KindScenario::PersonsActs();
  acts.emplace_back(kMeasuredPrint);
  return acts;
}

std::unique_ptr<KindTrial> DeltaScenario::BeginUnderKlipper(
    const Scenario& scenario, const Chance& chance) const {
  return BeginDeltaUnderKlipper(*this, scenario, chance);
}

std::unique_ptr<KindTrial> DeltaScenario::BeginUnderLinuxCnc(
    const Scenario& scenario, const Chance& chance) const {
  return BeginDeltaUnderLinuxCnc(*this, scenario, chance);
}

std::unique_ptr<KindTrial> DeltaScenario::Begin(const Scenario& scenario,
                                                const Chance& chance) const {
  return std::make_unique<DeltaTrial>(*this, scenario.machine.machine, chance);
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

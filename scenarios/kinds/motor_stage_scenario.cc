#include "scenarios/kinds/motor_stage_scenario.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "scenarios/kinds/motor_stage_effects.h"
#include "scenarios/kinds/motor_stage_trial.h"
#include "sim/base/units.h"

namespace caltwin {

namespace {

constexpr std::array<const char*, 12> kFigures = {"alerts",
                                                  "retries",
                                                  "warnings",
                                                  "safe_modes",
                                                  "index_edges",
                                                  "wrong_turn_probability",
                                                  "skew_ms",
                                                  "standstill_ms",
                                                  "stop_feasible",
                                                  "stopped_within",
                                                  "positions_lost",
                                                  "history_entries"};
constexpr std::array<const char*, 4> kValues = {
    "backlash", "home_offset", "travel", "start_lead"};

/// A field of the record that a scenario sets before it begins.
struct MotorSettingKey {
  const char* key = "";
  int code = 0;                     ///< Its M-code.
  std::optional<bool> is_rotary{};  ///< Of these axes only.
};
constexpr std::array<MotorSettingKey, 5> kSettingKeys = {
    {{"steps_per_mm", 92, false},
     {"steps_per_deg", 92, true},
     {"home_offset_mm", 206, false},
     {"home_offset_deg", 206, true},
     {"pulses_per_rev", 812}}};

void ReadSettings(YamlMap map, MotorStageTruth* scenario) {
  for (const MotorSettingKey& setting : kSettingKeys) {
    const auto value = map.Optional(setting.key);
    if (!value) continue;
    YamlMap by_axis = value->Map();
    for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
      const bool is_rotary = scenario->drawing.axes[i].is_rotary;
      if (setting.is_rotary.value_or(is_rotary) != is_rotary) continue;
      // Of a stepper nothing counts turns against a stored offset.
      if (setting.code == 206 && !scenario->drawing.axes[i].is_servo) continue;
      const auto number = by_axis.Optional(MotorAxisName(i));
      if (!number) continue;
      const Bounds bounds = setting.code == 206 ? Bounds{-1e4, 1e4} : Bounds{1e-3, 1e7};
      scenario->settings.push_back({setting.code, {i, number->Number(bounds)}});
    }
    by_axis.NoMoreKeys();
  }
  map.NoMoreKeys();
}

void ReadMotorTruth(YamlMap* map, MotorStageTruth* scenario) {
  if (const auto effects = map->Optional("effects")) {
    scenario->effects = ReadMotorEffects(effects->Map(), scenario->drawing);
  }
  if (const auto settings = map->Optional("settings")) {
    ReadSettings(settings->Map(), scenario);
  }
}

}  // namespace

MotorStageTruth ReadMotorTruthFile(const std::filesystem::path& file,
                                   const MotorStageDrawing& drawing) {
  MotorStageTruth truth{.drawing = drawing};
  Faults faults;
  YamlMap map = ReadYamlFile(file, &faults);
  ReadMotorTruth(&map, &truth);
  map.NoMoreKeys();
  faults.ThrowIfAny();
  return truth;
}

void MotorStageScenario::ReadKeys(YamlMap* map, Scenario* /*scenario*/) {
  ReadMotorTruth(map, this);
  if (const auto instruments = map->Optional("instruments")) {
    YamlMap by_name = instruments->Map();
    if (const auto laser = by_name.Optional("laser")) {
      YamlMap keys = laser->Map();
      laser_sigma_unit = MmFromUm(keys.NumberOr("sigma_um", 0.5, {0.001, 1000}));
      keys.NoMoreKeys();
    }
    by_name.NoMoreKeys();
  }
}

std::vector<Word> MotorStageScenario::ScenarioSteps() const {
  return {
      Word{"power_cut",
           "A step: the power goes while lines are obeyed, after after_bytes (0) more "
           "bytes of the flash, and comes back: what the flash holds is in force, and "
           "no "
           "axis is homed. lines: [M500 X]."}};
}

CalibrationStep MotorStageScenario::ReadScenarioStep(const std::string& name,
                                                     YamlMap options) const {
  PowerCut cut;
  if (const auto lines = options.Optional("lines")) {
    for (const YamlValue& line : lines->List()) cut.lines.push_back(line.Text());
  }
  cut.after_bytes =
      static_cast<std::uint64_t>(options.IntegerOr("after_bytes", 0, 0, 1'000'000));
  options.NoMoreKeys();
  return {.name = name, .perform = [cut](KindTrial* trial) {
            return dynamic_cast<MotorStageTrial&>(*trial).CutPower(cut);
          }};
}

Expectable MotorStageScenario::CanExpect() const {
  Expectable expectable{.figures = {kFigures.begin(), kFigures.end()}};
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    expectable.figures.push_back("home." + MotorAxisName(i));
    expectable.figures.push_back("compensated." + MotorAxisName(i));
    for (const char* value : kValues) {
      expectable.parameters.push_back(fmt::format("{}.{}", value, MotorAxisName(i)));
    }
  }
  return expectable;
}

std::vector<std::string> MotorStageScenario::EffectNames() const {
  return MotorEffectNames();
}

void MotorStageScenario::Vary(const std::string& effect,
                              const std::string& parameter,
                              const YamlValue& value,
                              Scenario* /*scenario*/) {
  for (const MotorEffectSpec& spec :
       ReadMotorEffects(value.Within(effect, parameter), drawing)) {
    std::erase_if(effects, [&](const MotorEffectSpec& had) {
      return had.effect == spec.effect && had.parameter == spec.parameter &&
             had.axis == spec.axis;
    });
    effects.push_back(spec);
  }
}

std::unique_ptr<KindTrial> MotorStageScenario::Begin(const Scenario& scenario,
                                                     const Chance& chance) const {
  return std::make_unique<MotorStageTrial>(*this, scenario.file, chance);
}

BuiltMotorStage DrawMotorStage(const MotorStageTruth& truth,
                               std::uint64_t seed,
                               std::uint64_t sample) {
  BuiltMotorStage built{.drawing = truth.drawing};
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    const MotorAxisDrawing& d = truth.drawing.axes[i];
    built.motors[i].drawing = d;
    built.faults[i].start_unit = (d.min_unit + d.max_unit) / 4;
  }
  for (const MotorEffectSpec& spec : truth.effects) {
    Rng rng(
        seed,
        sample,
        fmt::format("{}.{}.{}", spec.effect, MotorAxisName(spec.axis), spec.parameter));
    ApplyMotorEffect(spec, Draw(spec.value, &rng), &built);
  }
  return built;
}

}  // namespace caltwin

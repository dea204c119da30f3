#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "scenarios/scenario.h"
#include "sim/base/yaml.h"
#include "sim/kinds/motor_stage/rig.h"

namespace caltwin {

/// One number of a motor axis that a scenario gives, perhaps still to be drawn.
struct MotorEffectSpec {
  std::string effect{};     ///< "backlash"
  std::string parameter{};  ///< "gap", without its unit.
  std::size_t axis = 0;
  Distribution value = 0.0;  ///< As written: mm, deg, um, ms, kg, N, a fraction.
  std::string unit{};        ///< Behind the parameter's name; empty: a plain number.
};

/// The step `power_cut`: the power goes while lines are obeyed.
struct PowerCut {
  std::vector<std::string> lines{};
  std::uint64_t after_bytes = 0;  ///< That many are stored yet.
};

/// How a motor stage differs from its drawing, and what its controller believes.
struct MotorStageTruth {
  MotorStageDrawing drawing{};
  std::vector<MotorEffectSpec> effects{};
  /// settings: {home_offset_mm: {x: }, pulses_per_rev: {x: }, steps_per_deg: {a: }}, by
  /// M-code.
  std::vector<std::pair<int, std::pair<std::size_t, double>>> settings{};
};

/// What a motor stage's scenario has of its own; its machine is in it.
class MotorStageScenario : public KindScenario, public MotorStageTruth {
 public:
  std::optional<double> laser_sigma_unit{};  ///< instruments: {laser: {sigma_um: }}

  std::unique_ptr<KindScenario> Clone() const override {
    return std::make_unique<MotorStageScenario>(*this);
  }
  void ReadKeys(YamlMap* map, Scenario* scenario) override;
  Procedures KnownProcedures() const override { return ProceduresOf("motor_stage"); }
  std::string_view Owner() const override { return "a motor stage"; }
  std::vector<Word> ScenarioSteps() const override;
  std::span<const Word> OwnEffects() const override;
  CalibrationStep ReadScenarioStep(const std::string& name,
                                   YamlMap options) const override;
  Expectable CanExpect() const override;
  std::vector<std::string> EffectNames() const override;
  void Vary(const std::string& effect,
            const std::string& parameter,
            const YamlValue& value,
            Scenario* scenario) override;
  std::unique_ptr<KindTrial> Begin(const Scenario& scenario,
                                   const Chance& chance) const override;
  bool HasRows() const override { return false; }
};

/// Reads a file of `effects` and `settings` of such a stage. Throws InputError where it
/// is not that.
MotorStageTruth ReadMotorTruthFile(const std::filesystem::path& file,
                                   const MotorStageDrawing& drawing);

/// The stage that the effects make, their numbers drawn.
BuiltMotorStage DrawMotorStage(const MotorStageTruth& truth,
                               std::uint64_t seed,
                               std::uint64_t sample);

}  // namespace caltwin

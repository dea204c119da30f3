#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calibration/kinds/triple_z/printer.h"
#include "scenarios/scenario.h"
#include "sim/base/yaml.h"
#include "sim/effects/injected.h"
#include "sim/kinds/triple_z/plant.h"
#include "sim/machine/kinds/triple_z/drawing.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// What a triple-Z printer's scenario has of its own. Effects that want temperatures or
/// times are faults: nothing here has them.
class TripleZScenario : public KindScenario {
 public:
  std::vector<InjectedSpec> effects{};  ///< The machine file's own first.
  Pivots<double> believed_mm{};  ///< settings: {screws_at_mm: {z1: [x, y]}}, as M671.
  double steps_per_mm = 800;     ///< settings: {steps_per_mm: {z: }}
  double probe_sigma_mm = 0;     ///< instruments: {probe: {sigma_um: }}
  ProbeInput probe = ProbeInput::kWired;  ///< firmware: {probe: }
  std::optional<int> still_alone{};       ///< firmware: {still_alone: z2}

  std::unique_ptr<KindScenario> Clone() const override {
    return std::make_unique<TripleZScenario>(*this);
  }
  void ReadKeys(YamlMap* map, Scenario* scenario) override;
  Procedures KnownProcedures() const override { return ProceduresOf("triple_z"); }
  std::string_view Owner() const override { return "a triple-Z printer"; }
  std::vector<Word> ScenarioSteps() const override;
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
  bool CanBeUnderKlipper() const override { return true; }
  std::unique_ptr<KindTrial> BeginUnderKlipper(const Scenario& scenario,
                                               const Chance& chance) const override;
};

/// The machine that the effects make, their numbers drawn.
BuiltTripleZ DrawTripleZ(const TripleZScenario& scenario,
                         const Machine& machine,
                         std::uint64_t seed,
                         std::uint64_t sample);

}  // namespace caltwin

#pragma once

#include <memory>
#include <string>
#include <vector>

#include "scenarios/scenario.h"
#include "sim/base/yaml.h"
#include "sim/kinds/delta/effects.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// What a delta's scenario has of its own. The twin that firmware drives has parts and
/// a bed, carriages with play among them: other effects of drives, heat and probe are
/// faults.
class DeltaScenario : public KindScenario {
 public:
  DeltaEffects effects{};
  DeltaModel<double> settings{};  ///< What the firmware wrongly believes.
  /// settings: {probe_offset_mm: [x, y, z]}, sent as M851.
  Vec3<double> probe_offset_mm = Vec3<double>::Zero();
  double probe_sigma_mm = 0;  ///< instruments: {probe: {sigma_um: }}
  double calliper_sigma_mm = 0.02;
  double print_radius_mm = 0;  ///< Of the drawing: where there is a bed.

  std::unique_ptr<KindScenario> Clone() const override {
    return std::make_unique<DeltaScenario>(*this);
  }
  void ReadKeys(YamlMap* map, Scenario* scenario) override;
  Procedures KnownProcedures() const override { return ProceduresOf("delta"); }
  std::string_view Owner() const override { return "a delta"; }
  std::span<const Word> OwnEffects() const override;
  Expectable CanExpect() const override;
  std::vector<std::string> EffectNames() const override { return DeltaEffectNames(); }
  void Vary(const std::string& effect,
            const std::string& parameter,
            const YamlValue& value,
            Scenario* scenario) override;
  std::unique_ptr<KindTrial> Begin(const Scenario& scenario,
                                   const Chance& chance) const override;
  bool CanBeUnderKlipper() const override { return true; }
  std::unique_ptr<KindTrial> BeginUnderKlipper(const Scenario& scenario,
                                               const Chance& chance) const override;
  std::vector<std::string> PersonsActs() const override;
  bool CanBeUnderLinuxCnc() const override { return true; }
  std::unique_ptr<KindTrial> BeginUnderLinuxCnc(const Scenario& scenario,
                                                const Chance& chance) const override;
};

/// What is no part of the twin that firmware drives, as faults.
void RequireDeltaParts(const DeltaEffects& effects, Faults* faults);

/// The machine that the effects make, their numbers drawn.
BuiltDelta DrawDelta(const DeltaScenario& scenario,
                     const Machine& machine,
                     std::uint64_t seed,
                     std::uint64_t sample);

}  // namespace caltwin

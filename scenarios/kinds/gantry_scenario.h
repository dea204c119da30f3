#pragma once

#include "scenarios/scenario.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {

/// A gantry's part of a scenario, or that of another machine with one tip and no kinds
/// of steps of its own. Its keys are members of Scenario itself: effects, settings,
/// instruments, artefacts, firmware.
class GantryScenario : public KindScenario {
 public:
  explicit GantryScenario(const MachineKind* kind = CartesianKind())
      : machine_kind_(kind) {}
  std::unique_ptr<KindScenario> Clone() const override {
    return std::make_unique<GantryScenario>(*this);
  }
  void ReadKeys(YamlMap* map, Scenario* scenario) override;
  Procedures KnownProcedures() const override;
  std::string_view Owner() const override {
    return machine_kind_->axes_are_drives() ? "a gantry" : "a machine on belts";
  }
  Expectable CanExpect() const override;
  std::vector<std::string> EffectNames() const override;
  void Vary(const std::string& effect,
            const std::string& parameter,
            const YamlValue& value,
            Scenario* scenario) override;
  bool VariesMore() const override { return true; }
  void CheckVaried(const Scenario& scenario, Faults* faults) const override;
  std::unique_ptr<KindTrial> Begin(const Scenario& scenario,
                                   const Chance& chance) const override;
  bool CanBeUnderKlipper() const override { return true; }
  std::unique_ptr<KindTrial> BeginUnderKlipper(const Scenario& scenario,
                                               const Chance& chance) const override;
  bool CanBeUnderLinuxCnc() const override { return machine_kind_->axes_are_drives(); }
  std::unique_ptr<KindTrial> BeginUnderLinuxCnc(const Scenario& scenario,
                                                const Chance& chance) const override;

 private:
  const MachineKind* machine_kind_;  ///< As ReadKeys finds it.
};

/// `firmware: {probe: missing | open | stuck}`: how the probe reaches the controller.
ProbeInput ReadProbeInput(YamlMap* map);

/// The values that `varied` gives replace those of the same effect on the same axis.
void ReplaceEffect(const InjectedSpec& varied,
                   const std::string& parameter,
                   std::vector<InjectedSpec>* effects);

/// `vary: {EFFECT.PARAMETER: value}` of the catalogue's effects on that machine.
void VaryEffects(const std::string& effect,
                 const std::string& parameter,
                 const YamlValue& value,
                 const Machine& machine,
                 std::vector<InjectedSpec>* effects);

}  // namespace caltwin

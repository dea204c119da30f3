#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "calibration/kinds/triple_z/procedures.h"
#include "scenarios/scenario.h"
#include "sim/base/yaml.h"
#include "sim/effects/injected.h"
#include "sim/kinds/triple_z/plant.h"
#include "sim/machine/kinds/triple_z/drawing.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// One entry of a triple-Z printer's `calibrate:`.
struct TripleZStep {
  std::string name{};  ///< plane_tilt, ..., move_triple_z.
  TripleZOptions options{};
  Eigen::Vector2d at_mm = Eigen::Vector2d::Zero();  ///< Of move_triple_z: the nozzle,
  Vec3<double> heights_mm = Vec3<double>::Zero();   ///< and the screws.
};

/// What a triple-Z printer's scenario has of its own. Effects that want temperatures or
/// times are faults: nothing here has them.
class TripleZScenario : public KindScenario {
 public:
  std::vector<InjectedSpec> effects{};  ///< The machine file's own first.
  Pivots<double> believed_mm{};  ///< settings: {screws_at_mm: {z1: [x, y]}}, as M671.
  double steps_per_mm = 800;     ///< settings: {steps_per_mm: {z: }}
  double probe_sigma_mm = 0;     ///< instruments: {probe: {sigma_um: }}

  std::unique_ptr<KindScenario> Clone() const override {
    return std::make_unique<TripleZScenario>(*this);
  }
  void ReadKeys(YamlMap* map, Scenario* scenario) override;
  std::vector<std::string> StepNames() const override;
  CalibrationStep ReadStep(const std::string& name,
                           const YamlValue& options,
                           const std::string& usual_axis) const override;
  void RefuseStep(const std::string& name, const YamlValue& options) const override;
  Expectable CanExpect() const override;
  std::vector<std::string> EffectNames() const override;
  void Vary(const std::string& effect,
            const std::string& parameter,
            const YamlValue& value,
            Scenario* scenario) override;
  std::unique_ptr<KindTrial> Begin(const Scenario& scenario,
                                   const Chance& chance) const override;
};

/// The machine that the effects make, their numbers drawn.
BuiltTripleZ DrawTripleZ(const TripleZScenario& scenario,
                         const Machine& machine,
                         std::uint64_t seed,
                         std::uint64_t sample);

/// The steps of `calibrate:`.
std::vector<TripleZStep> ReadTripleZSteps(const YamlValue& list);

}  // namespace caltwin

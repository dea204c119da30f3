#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>

#include "sim/base/rng.h"
#include "sim/controllers/plant_board.h"
#include "sim/firmware/stepped_plant.h"
#include "sim/kinds/delta/plant.h"
#include "sim/kinds/delta/world.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// A simulated delta, closed form or MuJoCo, whose towers are stepped one by one.
/// Motors as DeltaTwinPlant has them: steps of travel down from the endstops.
///
/// The probe acts where the nozzle, taken straight up from there by all three towers
/// alike, would let go of the bed only further up. That is where a descent triggers but
/// for what it moves sideways meanwhile.
class SteppedDelta final : public SteppedPlant {
 public:
  /// @param is_physics  MuJoCo finds the trigger
  SteppedDelta(const Machine& machine,
               const BuiltDelta& built,
               bool is_physics,
               std::uint64_t seed);

  bool Acts(const PinSensor& sensor, const Motors& steps) override;
  void Follow(const Motors& /*steps*/) override {}
  void Arm(const PinSensor& sensor) override;

 private:
  bool ProbeActs(const Vec3<double>& motors_mm);

  Machine machine_;
  BuiltDelta built_;
  std::array<double, 3> steps_per_mm_;
  std::unique_ptr<DeltaWorld> world_{};  ///< Null: in closed form.
  Rng scatter_;
  double early_mm_ = 0;  ///< By how much chance has the probe now armed act too high.
};

/// How a delta is wired to a Klipper board: motors A, B, C, carriages counted up, their
/// endstops A_STOP, B_STOP, C_STOP at the top, the nozzle that feels the bed on PROBE.
/// When it is switched on the carriages hang at different heights below their endstops.
Wiring WiringOfDelta(const Machine& machine);

/// The printer.cfg of a delta, with what its firmware believes. Klipper has one radius
/// for all towers: of several their mean.
std::string PrinterCfgOfDelta(const Machine& machine, const std::string& serial);

}  // namespace caltwin

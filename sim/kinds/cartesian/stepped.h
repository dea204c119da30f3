#pragma once

#include <cstdint>
#include <memory>

#include "sim/base/rng.h"
#include "sim/controllers/plant_board.h"
#include "sim/firmware/stepped_plant.h"
#include "sim/machine/kinds/cartesian/drawing.h"
#include "sim/machine/machine.h"
#include "sim/twin/built.h"
#include "sim/twin/built_world.h"

namespace caltwin {

/// A machine with a touch probe on three axes whose motors are stepped one by one.
class SteppedTip : public SteppedPlant {
 public:
  /// Where the ball's centre truly is, the stylus not bent.
  virtual Vec3<double> Tip_mm() const = 0;
};

/// A machine of three drives with a touch probe whose motors are stepped one by one: a
/// gantry, a mill, a CoreXY. Where Y has a motor at each end of its beam the second one
/// is the fourth motor: the beam turns as the two come apart, and `racking` is how far
/// apart their home switches stand. Carriages stand where the play operator has them;
/// steps count from the home ends. In closed form, as FastPlant, the stylus is bent by
/// as much as the ball would otherwise be inside; in MuJoCo by what contact leaves of
/// it at rest, and the tip is where the built model has it. Its time stands still: what
/// comes with hours or heat does not act.
class SteppedGantry final : public SteppedTip {
 public:
  /// @param is_physics  MuJoCo has the tip and bends the stylus
  SteppedGantry(Built built, bool is_physics, std::uint64_t seed);

  bool Acts(const PinSensor& sensor, const Motors& steps) override;
  void Follow(const Motors& steps) override;
  void Arm(const PinSensor& sensor) override;
  Vec3<double> Tip_mm() const override;
  /// Where all motors stand that were homed on their switches and then told so, by
  /// axis.
  Motors TurnedOn(const Vec3<double>& steps) const;

 private:
  /// Where the motors have the drives.
  struct Stand {
    Vec3<double> steps = Vec3<double>::Zero();
    double racking_mrad = 0;  ///< Of a beam whose two motors stand apart.
  };
  Stand StandAt(const Motors& motors) const;
  Vec3<double> LagAt_mm(const Stand& stand) const {
    return built_.LagAt_mm(lag_mm_, stand_.steps, stand.steps);
  }
  /// How far a beam that stands askew has moved the tip.
  Vec3<double> MovedByRacking_mm(const Stand& stand, const Vec3<double>& lag_mm) const;
  Vec3<double> TipAt_mm(const Stand& stand, const Vec3<double>& lag_mm) const;
  bool ProbeActs(const Stand& stand) const;
  bool SwitchActs(int motor, const Motors& motors) const;

  Built built_;              ///< Of a beam without its racking, which its motors make.
  const BeamDrawing* beam_;  ///< Null: Y has one motor.
  double apart_mm_ = 0;      ///< By how much its second switch stands further up Y.
  Rng scatter_;
  Stand stand_{};
  Vec3<double> lag_mm_;  ///< Carriage minus motor, by drive.
  double late_mm_ = 0;   ///< By how much chance has the probe now armed act too deep.
  std::unique_ptr<BuiltWorld> world_{};  ///< Null: in closed form.
};

/// How such a machine is wired to a board: motors X, Y, Z (of belts: the two
/// and Z), of a beam with two Y1 last, each with an endstop of its name (X_STOP) at its
/// home end, the probe on PROBE. When it is switched on it stands in the middle, well
/// off its table.
Wiring WiringOfGantry(const Machine& machine);

}  // namespace caltwin

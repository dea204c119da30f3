#pragma once

#include <cstdint>

#include "sim/base/rng.h"
#include "sim/controllers/plant_board.h"
#include "sim/firmware/stepped_plant.h"
#include "sim/machine/kinds/cartesian/drawing.h"
#include "sim/machine/machine.h"
#include "sim/twin/built.h"

namespace caltwin {

/// A machine of three drives with a touch probe, in closed form, whose motors are
/// stepped one by one: a gantry, a mill, a CoreXY. Where Y has a motor at each end of
/// its beam the second one is the fourth motor: the beam turns as the two come apart,
/// and `racking` is how far apart their home switches stand. As FastPlant: carriages
/// stand where the play operator has them, the stylus is bent by as much as the ball
/// would otherwise be inside; steps count from the home ends. Its time stands still:
/// what comes with hours or heat does not act.
class SteppedGantry final : public SteppedPlant {
 public:
  SteppedGantry(Built built, std::uint64_t seed);

  bool Acts(const PinSensor& sensor, const Motors& steps) override;
  void Follow(const Motors& steps) override;
  void Arm(const PinSensor& sensor) override;
  /// Where the ball's centre truly is, the stylus not bent.
  Vec3<double> Tip_mm() const { return built_.Tip_mm(steps_, lag_mm_); }
  /// Where all motors stand that were homed on their switches and then told so, by
  /// axis.
  Motors TurnedOn(const Vec3<double>& steps) const;

 private:
  /// The axes' steps where the motors stand so; turns the beam with them.
  Vec3<double> Axes(const Motors& steps);
  /// A beam that is turned by more than 50 mrad is jammed.
  void RequireUnjammed(const Motors& steps) const;
  bool SwitchActs(int motor, const Motors& steps);
  bool ProbeActs(const Motors& steps);
  Vec3<double> LagAt_mm(const Vec3<double>& steps) const {
    return built_.LagAt_mm(lag_mm_, steps_, steps);
  }
  /// `steps` of the drives, whose carriages lag so.
  double BeforeHome_mm(Axis axis,
                       const Vec3<double>& steps,
                       const Vec3<double>& lag_mm) const;

  Built built_;
  Rng scatter_;
  Vec3<double> steps_;
  Vec3<double> lag_mm_;  ///< Carriage minus motor, by drive.
  double late_mm_ = 0;   ///< By how much chance has the probe now armed act too deep.
  const BeamDrawing* beam_;  ///< Null: Y has one motor.
  std::size_t racking_ = 0;  ///< Of a beam: which of the frame's effects turns it.
  double turned_mrad_ = 0;   ///< By where the motors were last followed to.
  double apart_mm_ = 0;      ///< By how much its second switch stands further up Y.
};

/// How such a machine is wired to a board: motors X, Y, Z (of belts: the two
/// and Z), of a beam with two Y1 last, each with an endstop of its name (X_STOP) at its
/// home end, the probe on PROBE. When it is switched on it stands in the middle, well
/// off its table.
Wiring WiringOfGantry(const Machine& machine);

}  // namespace caltwin

#include "sim/effects/angular.h"

#include "sim/base/units.h"
#include "sim/effects/acts/edits.h"

namespace caltwin {
namespace {

// Turns about a point of the carriage where what it carries is in mid-travel.
void TwistRail(
    const Machine& machine, Axis carriage, Axis about, double change_rad, Mjcf* model) {
  Vec3<double> pivot_mm = Vec3<double>::Zero();
  for (const Axis carried : kAxes) {
    if (PlaceInChain(carried) > PlaceInChain(carriage)) {
      pivot_mm[Index(carried)] = machine.axis(carried).mid_mm();
    }
  }
  model->TwistRail(carriage, about, change_rad, pivot_mm, machine.axis(carriage));
}

}  // namespace

void EditAngular(const Machine& machine, const Injected& injected, Mjcf* model) {
  if (injected.values[0] == 0) return;
  TwistRail(machine,
            MovingAxis(injected.axis),
            AxisOfRotation(injected.axis[1]),
            RadFromUrad(injected.values[0]),
            model);
}

void EditAxisTwist(const Machine& machine, const Injected& injected, Mjcf* model) {
  if (injected.values[0] == 0) return;
  TwistRail(machine, Axis::kX, Axis::kX, RadFromMrad(injected.values[0]), model);
}

}  // namespace caltwin

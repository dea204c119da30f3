#pragma once

#include <cmath>

#include "sim/effects/effect.h"

namespace caltwin {

/// @name The gantry's chain of carriages, which the frame's closed forms share
/// The y carriage carries the x carriage, which carries the z slide with the probe
/// (models/gantry_router): an error of one is felt by all that it carries.

/// Where an axis stands in its travel: -1 at the minimum, 0 in the middle, +1 at the
/// maximum.
template <typename T>
T OverTravel(const Machine& machine, Axis axis, const T& q_mm) {
  const AxisDrawing& drawing = machine.axis(axis);
  return (q_mm - drawing.mid_mm()) / (drawing.travel_mm() / 2);
}

/// The shape of a bow over the travel, 1 from its middle to its ends, without mean:
/// U^2 - 1/3.
template <typename T>
T Bow(const Machine& machine, Axis axis, const T& q_mm) {
  const T u = OverTravel(machine, axis, q_mm);
  return u * u - 1.0 / 3.0;
}

/// 0 for the carriage that stands on the frame (y), 1 and 2 for those it carries.
constexpr int PlaceInChain(Axis axis) {
  constexpr std::array kPlaces = {1, 0, 2};
  return kPlaces[static_cast<std::size_t>(Index(axis))];
}

/// The axis about which a rotation of that ISO 230-1 letter turns: A x, B y, C z.
constexpr Axis AxisOfRotation(char letter) {
  return kAxes[static_cast<std::size_t>(letter - 'A')];
}

/// "EBX": the third letter is the axis that moves, the second what errs with it.
constexpr Axis MovingAxis(std::string_view error_name) {
  return kAxes[static_cast<std::size_t>(error_name[2] - 'X')];
}

/// From the pivot of a carriage's rotation to the tip [mm]: the probe's offset, and
/// where the carriages that it carries stand, from the middle of their travels.
template <typename T>
Vec3<T> LeverOn(const Asked<T>& asked, Axis carriage) {
  Vec3<T> lever_mm = asked.at.probe_off_mm.template cast<T>();
  for (const Axis carried : kAxes) {
    if (PlaceInChain(carried) <= PlaceInChain(carriage)) continue;
    lever_mm[Index(carried)] +=
        asked.q_mm[Index(carried)] - asked.machine.axis(carried).mid_mm();
  }
  return lever_mm;
}

/// A carriage turns about an axis while it moves: by `change_rad` over its travel,
/// not at all in the middle.
///
///   motion += sin(theta) e x r + (1 - cos(theta)) e x (e x r),
///   theta = change U / 2, right-handed about e
template <typename T>
void AddRotationOf(const Vec3<T>& lever_mm,
                   const Asked<T>& asked,
                   Axis carriage,
                   Axis about,
                   const T& change_rad,
                   Errors<T>* errors) {
  using std::cos;
  using std::sin;
  const T theta_rad = change_rad / 2.0 *
                      OverTravel(asked.machine, carriage, asked.q_mm[Index(carriage)]);
  const int u = (Index(about) + 1) % 3;  // From u to v is the right-handed sense.
  const int v = (Index(about) + 2) % 3;
  const T less = 1.0 - cos(theta_rad);
  errors->motion_mm[u] -= sin(theta_rad) * lever_mm[v] + less * lever_mm[u];
  errors->motion_mm[v] += sin(theta_rad) * lever_mm[u] - less * lever_mm[v];
}

/// The same of a carriage in the chain, r = LeverOn.
template <typename T>
void AddRotation(const Asked<T>& asked,
                 Axis carriage,
                 Axis about,
                 const T& change_rad,
                 Errors<T>* errors) {
  AddRotationOf(LeverOn(asked, carriage), asked, carriage, about, change_rad, errors);
}

}  // namespace caltwin

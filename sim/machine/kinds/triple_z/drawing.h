#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include <Eigen/Core>
#include <Eigen/LU>

#include "sim/base/yaml.h"
#include "sim/machine/axis.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// The screws that carry the bed of a triple-Z printer.
inline constexpr int kNumScrews = 3;
/// "z1", "z2", "z3".
std::string ScrewName(int screw);
/// The screw of that name; nullopt for anything else.
std::optional<int> ScrewNamed(std::string_view name);

/// Where the screws stand, seen from above, machine axes [mm].
template <typename T>
using Pivots = std::array<Eigen::Matrix<T, 2, 1>, kNumScrews>;

/// By how much each screw's height counts in that of the bed's plane over (x, y): the
/// barycentric coordinates of the point in the triangle of the screws, which sum to 1.
///
///   bed(x, y) = sum w_i(x, y) height_i
///
/// Exact for a plane on balls that sit on the screws' axes (grooves in the bed).
/// Outside the triangle weights are negative or above 1. Not numbers where the screws
/// stand in one line.
template <typename T>
Vec3<T> ScrewWeights(const Pivots<T>& pivots_mm, const T& x_mm, const T& y_mm) {
  const Eigen::Matrix<T, 2, 1> a = pivots_mm[1] - pivots_mm[0];
  const Eigen::Matrix<T, 2, 1> b = pivots_mm[2] - pivots_mm[0];
  const T dx = x_mm - pivots_mm[0][0], dy = y_mm - pivots_mm[0][1];
  const T area = a[0] * b[1] - a[1] * b[0];
  const T second = (dx * b[1] - dy * b[0]) / area;
  const T third = (a[0] * dy - a[1] * dx) / area;
  return {T(1) - second - third, second, third};
}

/// One screw as drawn.
struct ScrewDrawing {
  Eigen::Vector2d at_mm = Eigen::Vector2d::Zero();
  double lead_mm = 4;
  double full_steps_per_rev = 200;
  double microsteps = 16;

  double steps_per_mm() const { return full_steps_per_rev * microsteps / lead_mm; }
};

/// What a triple-Z printer's drawing has beside its axes. Motors count the height of
/// their screw above the lower endstop, + raises the bed there. The nozzle's height is
/// that of the machine's frame, so with all screws at `top_mm` the drawn bed meets it:
///
///   z_i = top - z,   z the commanded nozzle height over the bed
struct TripleZDrawing {
  std::array<ScrewDrawing, kNumScrews> screws = {
      ScrewDrawing{{20, 20}}, ScrewDrawing{{215, 20}}, ScrewDrawing{{20, 215}}};
  double top_mm = 250;

  Pivots<double> pivots_mm() const {
    return {screws[0].at_mm, screws[1].at_mm, screws[2].at_mm};
  }
};

/// Smallest height of the triangle over its longest side: 0 for screws in one line.
double TriangleShape(const Pivots<double>& pivots_mm);

/// Reads `screws: {z1: {at_mm: [20, 20], lead_mm: 4, ...}}`; what is left out is as
/// above. Screws nearly in one line are a fault.
TripleZDrawing ReadTripleZDrawing(YamlMap* map);

/// The drawing of a triple-Z printer, which the machine must be.
inline const TripleZDrawing& TripleZOf(const Machine& machine) {
  return *machine.Own<TripleZDrawing>();
}
inline TripleZDrawing& TripleZOf(Machine& machine) {
  return *machine.Own<TripleZDrawing>();
}

}  // namespace caltwin

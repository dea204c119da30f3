#pragma once

#include <array>

namespace caltwin {

/// `beam: {motors_at_x_mm: [-20, 320]}` of a gantry whose Y has a motor and a home
/// switch at each end of its beam. A firmware that knows one motor steps both alike;
/// one that homes each on its own switch leaves the beam as its switches stand:
/// `racking`.
struct BeamDrawing {
  std::array<double, 2> motors_at_x_mm{};

  double apart_mm() const { return motors_at_x_mm[1] - motors_at_x_mm[0]; }
  /// The part of the second motor's way that the beam goes at x.
  double Share(double x_mm) const { return (x_mm - motors_at_x_mm[0]) / apart_mm(); }
};

}  // namespace caltwin

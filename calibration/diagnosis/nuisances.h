#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "calibration/diagnosis/observed.h"

namespace caltwin {

/// One unknown that is always fitted and never a finding, or the freedom of form that a
/// finding is granted: its name, its column, and how far it may reasonably go.
struct Nuisance {
  std::string name{};  ///< "scale.x", "placement.first.z", ...
  std::string unit{};
  Eigen::VectorXd column_mm{};  ///< What one unit adds to each row.
  double prior_sd = 1;          ///< In the unit, about 0.
  double offset = 0;            ///< Reported value = offset + fitted.
  bool reported = true;
};

/// The baseline of a gantry (docs/diagnosis.md): scale and backlash of each axis,
/// pre-travels, the bed's plane, the place of everything, the ball-bar's length, sizes
/// of artefacts within their stated uncertainty, and the freedom of form of the effects
/// that the model already holds.
std::vector<Nuisance> BaselineOf(const Observed& observed);

}  // namespace caltwin

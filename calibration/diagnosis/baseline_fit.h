#pragma once

#include <Eigen/Core>

#include "calibration/diagnosis/observed.h"

namespace caltwin {

/// The baseline alone, all rows counting alike but those far out, which count for
/// nothing.
struct BaselineFit {
  Eigen::VectorXd left_mm{};  ///< Reading less fit, by row.
  /// What the rows tell well enough to be linear about.
  BaselinePoint point{};
};
BaselineFit FitBaseline(const Observed& observed);

/// The rows as the baseline has them: touches taken where it says that they trigger,
/// rows read inside a gap with the sense they have there, pre-travel as large as it is
/// in each direction. In rounds, since what decides upon rows is fitted to them.
Observed AtBaseline(const Observed& as_read);

}  // namespace caltwin

#pragma once

#include <vector>

#include <Eigen/Core>

#include "calibration/diagnosis/candidates.h"
#include "calibration/diagnosis/weighing.h"

namespace caltwin {

/// How much of what could be explained beside the rest the plain shape of a name
/// explains, without freedom of form:
///
///   (before - after) / (before - dof)
///
/// before and after: residual sums of squares in sigma, without and with the shape. 1
/// where nothing but noise is left, below a half where more is left than was explained:
/// a lack of fit that the name has no right to leave. `beside`: baseline and all other
/// findings.
double PlainShare(const Observed& observed,
                  const Circumstances& beside,
                  const Eigen::MatrixXd& columns_mm);

/// Whether a jump is told no better than a gradual change of the same rows: a ramp over
/// several of them, or a creep that slows down. The rows next to a jump tell both
/// apart. False for causes that do not jump.
bool IsGradual(const Observed& observed,
               const Circumstances& beside,
               const Candidate& candidate);

/// Whether the rows next to a jump are full of outliers: then the readings were
/// disturbed there, and no level can be told from them. False for causes that do not
/// jump.
bool IsAmongOutliers(const Observed& observed,
                     const std::vector<bool>& is_outlier,
                     const Candidate& candidate,
                     const Variant& variant);

}  // namespace caltwin

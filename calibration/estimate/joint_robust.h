#pragma once

#include "calibration/estimate/joint.h"
#include "calibration/estimate/joint_model.h"
#include "calibration/estimate/robust.h"

namespace caltwin {

/// Fills in the covariances of a joint fit that rest on its residuals: by rows, and by
/// the observations' groups. `sandwich` is in the model's own scale.
void AddRobust(const JointModel& model,
               const JointProblem& problem,
               const Sandwich& sandwich,
               JointFit* fit);

}  // namespace caltwin

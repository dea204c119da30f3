// How sure a joint estimate is of what it says: the covariance that suits its readings,
// and what a run is told of every unknown.
#pragma once

#include <array>

#include "calibration/loop/session.h"
#include "calibration/procedures/joint_estimate.h"

namespace caltwin {

// Where the readings contradict the noise stated (chi2 per degree of freedom) their own
// scatter takes its place, for every unknown alike: a model that does not suit them
// spoils any of them.
void BelieveScatter(Session* session, JointFit* fit);

// Uncertainties from the residuals themselves, row by row (HC3) or face by face.
void TakeRobust(Session* session, JointOptions::Scatter scatter, JointFit* fit);

// Everything that has no setting, and every setting's last word; `applied`: by axis,
// whether its settings were changed and kept.
void ConcludeAll(Session* session,
                 const JointOptions& o,
                 const JointFit& fit,
                 const std::array<bool, 3>& applied);

// How the errors of everything told go together.
void ConcludeCorrelations(Session* session, const JointOptions& o, const JointFit& fit);

}  // namespace caltwin

#pragma once

#include "calibration/diagnosis/diagnosis.h"
#include "calibration/diagnosis/remains.h"

namespace caltwin {

/// Where nothing was found, but far more than noise is there, the verdict becomes
/// `unknown`: these rows cannot say what. So too where nothing but the fastest wander
/// that is tried makes noise of it. Not where small effects were not asked for.
void DoubtNone(const Remains& left, Diagnosis* diagnosis);

/// Where the machine drifted and nothing foretells how, a remark says what goes along
/// with it: a lead and no finding.
void NameTheLead(Diagnosis* diagnosis);

}  // namespace caltwin

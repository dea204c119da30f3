#pragma once

#include "calibration/diagnosis/observed.h"

namespace caltwin {

/// What counting in whole steps leaves open of a reading on a delta whose header states
/// the steps/mm in force; 0 where it does not [mm].
///
///   sqrt(sum over towers (n . dp/dmotor step)^2 / 12)
///
/// Repeats count the same steps, so they do not show it.
double RoundingSigma_mm(const Observed& observed, Eigen::Index i);

}  // namespace caltwin

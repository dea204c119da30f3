#pragma once

#include <functional>

#include "calibration/estimate/joint.h"

namespace caltwin {

/// An interval by profile likelihood.
struct ProfileInterval {
  double low = 0;
  double high = 0;
  bool is_closed = false;  ///< Both ends were found within 20 standard deviations.
};

/// The values at which the least -2 log likelihood with one parameter held exceeds that
/// of the best by 3.841, the 95 % point of chi2 with one degree of freedom (Venzon and
/// Moolgavkar 1988):
///
///   { p : objective(p) - objective(best) <= 3.841 }
///
/// Of a linear model with normal noise this is best +- 1.96 sd exactly; where it is
/// not, the model bends within its own uncertainty and +- 1.96 sd is wrong.
/// @param objective  least -2 log likelihood with the parameter at that value
/// @param sd  of the linearised problem: where the search begins
ProfileInterval ProfileOf(const std::function<double(double)>& objective,
                          double best,
                          double sd);

/// Of one free parameter of a joint estimate, all others (nuisances too) fitted anew at
/// each value; squares alone, beliefs included. About 30 fits.
/// @param parameter  index in problem.free
ProfileInterval ProfileJoint(const JointProblem& problem,
                             const JointFit& fit,
                             std::size_t parameter);

}  // namespace caltwin

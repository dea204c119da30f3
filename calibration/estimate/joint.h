#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "calibration/estimate/observability.h"
#include "calibration/estimate/observation.h"
#include "calibration/estimate/uncertain.h"
#include "sim/effects/effect.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// One parameter to be estimated.
struct FreeParameter {
  int effect = 0;      ///< Index in the catalog.
  std::string axis{};  ///< "x", "x+", "C0Y", "" ...
  std::size_t parameter = 0;
  /// What another instrument said of it (a calliper on the ball): counts as a reading.
  std::optional<Given> measured{};
  /// Belief before any reading; none: from the declaration (DeclaredPrior). kNotGiven:
  /// no belief.
  std::optional<Given> prior{};
};

/// The prior of a parameter as its effect declares it, made normal: of a lognormal, the
/// half width of its 68 % interval. A parameter that replaces a drawing's value is
/// believed about the drawing's, not about the declaration's middle.
Given DeclaredPrior(const Machine& machine, const FreeParameter& parameter);

/// How outliers are met.
enum class Loss {
  kSquares,  ///< Every row counts in full.
  /// Huber at 1.345 standard deviations: 95 % as efficient as squares on honest rows;
  /// one wild row moves the estimate by no more than a row at 1.345 would.
  kHuber
};

struct JointProblem {
  Machine machine{};
  std::vector<Injected> fixed{};  ///< Effects with known values.
  std::vector<FreeParameter> free{};
  std::vector<Observation> observations{};
  /// What is known of nuisances ("probe_hysteresis"); those not in it are free.
  std::map<std::string, Given> nuisances{};
  Loss loss = Loss::kSquares;
  bool with_robust = false;  ///< Fill in the two robust covariances too.
};

/// What came out for one unknown.
struct JointEstimate {
  std::string name{};  ///< As in CONTRACT: "backlash.x", "placement.block.z".
  std::string unit{};
  double value = 0;
  double sd = 0;
  /// The readings alone, beliefs relaxed a thousandfold, know it to better than 0.9 of
  /// its prior's standard deviation. Where false, value and sd only repeat beliefs, or
  /// the fit did not converge.
  bool identifiable = false;
  double prior_sd = 0;  ///< Infinite where there was none.
  bool is_nuisance = false;
  /// What sd is made of: the readings, and each belief or other measurement by name
  /// ("prior of tip_size"); what adds less than a thousandth of the variance together.
  std::vector<Contribution> budget{};
};

struct JointFit {
  bool converged = false;
  std::string message{};                   ///< Why not, or what to know.
  std::vector<JointEstimate> estimates{};  ///< Free parameters, then nuisances.
  Eigen::MatrixXd covariance{};  ///< In the order of `estimates`, beliefs included.
  Eigen::MatrixXd correlation{};
  int rank = 0;  ///< Directions that the readings tell by themselves.
  ObservabilityReport observability{};
  std::vector<double> residuals_mm{};  ///< Reading less prediction, by observation.
  double rms_mm = 0;                   ///< Of the residuals, over the observations.
  /// Observations less the unknowns they paid for, trace of the hat matrix.
  double dof = 0;
  double chi2_per_dof = 0;  ///< Near 1 if sigmas are honest and the model suffices.
  /// What was minimised, with beliefs and (squares alone) without Huber's loss: -2 log
  /// of the posterior but for a constant.
  double objective = 0;
  /// Of the estimates as `covariance`, from the residuals themselves instead of the
  /// stated noise (robust.h): by rows (HC3), and by groups of observations (CR3).
  Eigen::MatrixXd hc3_covariance{};
  Eigen::MatrixXd group_covariance{};
  int num_groups = 0;

  /// By name; null where it was not free.
  const JointEstimate* Find(std::string_view name) const;
};

/// The joint estimate: all unknowns from all rows at once, through the one Predict.
///
/// Minimises  sum rho(((value - Predict - nuisances) / sigma)^2) + sum ((p - prior) /
/// sd)^2  by Ceres, derivatives automatic, parameters in units of their prior's sd. The
/// covariance is that of the linearised problem at the solution; with Huber's loss the
/// rows' part is widened by 1 / 0.95. Slight contamination (1 % of rows) adds a percent
/// to it, which is neglected.
JointFit FitJoint(const JointProblem& problem);

/// The verdict before anything is measured: values are not looked at, the Jacobian is
/// taken at the priors' middle.
ObservabilityReport ObserveJoint(const JointProblem& problem);

/// The machine as estimated: the fixed effects, and the free ones at their estimates.
/// What an extended model, a prediction or a correction starts from.
std::vector<Injected> EstimatedEffects(const JointProblem& problem,
                                       const JointFit& fit);

/// How well rows are predicted that were not fitted.
struct HoldOutError {
  double in_sample_rms_mm = 0;
  double held_out_rms_mm = 0;
  int predicted = 0;  ///< Rows; those with a nuisance no other group has are left out.
  int groups = 0;
};

/// Leaves out one group at a time, fits the others, predicts it.
HoldOutError HoldOut(const JointProblem& problem);

}  // namespace caltwin

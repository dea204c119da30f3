#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "calibration/diagnosis/observed.h"

namespace caltwin {

/// How readings scatter about the truth: each by its own sigma, and all together by a
/// slow wander of the tool against the table, a random walk in x, y and z.
struct Noise {
  Eigen::VectorXd sigma_mm{};
  double wander_mm2_per_s = 0;  ///< Variance gained per second, each direction.
};

/// Makes columns of rows white: divides by sigma or, with wander, takes the normalised
/// innovations of the Kalman filter that follows it. Linear, O(rows) a column.
class Whitener {
 public:
  Whitener(const Observed& observed, const Noise& noise);

  Eigen::MatrixXd operator()(const Eigen::MatrixXd& columns_mm) const;
  /// log |V|, V the covariance of the rows in mm^2.
  double log_det() const { return log_det_; }

 private:
  bool wanders_ = false;
  std::vector<Eigen::Index> order_{};         ///< As measured.
  std::vector<Eigen::Vector3d> direction_{};  ///< By order: how wander shows.
  std::vector<Eigen::Vector3d> gain_{};
  Eigen::VectorXd inverse_sd_{};  ///< Of each innovation, by row.
  double log_det_ = 0;
};

/// Standard deviation of one reading from replicates (same campaign, setup, pose,
/// sense, feed, load, spindle angle, offset and turn), by campaign; NaN where there are
/// fewer than `least_dof` degrees of freedom. Slow drift between replicates counts in.
struct PureError {
  std::vector<double> sigma_mm{};
  std::vector<int> dof{};
};
PureError RepeatsOf(const Observed& observed, int least_dof);
/// The same, but no less than what is rounded (RoundedTo_mm).
PureError PureErrorOf(const Observed& observed, int least_dof);
/// That of what is left of the rows, those left out aside; where rows have times
/// from each replicate to the next, so that a slow drift between them is none of it.
PureError PureErrorOf(const Observed& observed,
                      const Eigen::VectorXd& left_mm,
                      const std::vector<bool>& left_out,
                      int least_dof);

/// What a campaign's reading is uncertain by because its instrument shows whole steps,
/// step / sqrt(12), however alike repeats are [mm]; 0 where no step is stated.
double RoundedTo_mm(const Observed& observed, const std::string& campaign);

/// The same of rows that are replicates of each other, as in PureErrorOf.
std::string ReplicateKey(const Observed& observed, Eigen::Index i);

/// A first guess of each row's sigma: the stated one, else replicates, else the
/// residuals' own robust spread in its campaign.
Eigen::VectorXd GuessSigma_mm(const Observed& observed,
                              const Eigen::VectorXd& baseline_residual_mm);

}  // namespace caltwin

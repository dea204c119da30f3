#pragma once

#include <vector>

#include <Eigen/Core>

#include "calibration/diagnosis/evidence.h"

namespace caltwin {

/// How what a fit leaves of rows hangs together in time, and what that does to the
/// uncertainties of what was fitted.
///
/// Where residuals, white as the fit takes them, are alike from row to row: within a
/// stream (the rows of one campaign along one axis, as measured) errors are taken as
/// two parts, one independent from row to row, one that fades:
///
///   cov(i, k) = s^2 ((1 - share) [i = k] + share exp(-|t_i - t_k| / tau))
///
/// s in each row's sigma. Share and tau are averaged over a grid by their restricted
/// likelihood, the nuisances projected out; the noise as the fit has it (white, or with
/// a random walk) has half of the weight beforehand. Sizes are those of the
/// fit as it was made; only how sure they are changes (a sandwich: G' cov G for weights
/// G upon rows). Neglects what hangs together for longer than a stream lasts: the fit
/// takes that for its own.
class TimeNoise {
 public:
  /// @param nuisances  all that was fitted
  TimeNoise(const Observed& observed,
            const Noise& noise,
            const std::vector<Nuisance>& nuisances,
            const std::vector<bool>& left_out = {});

  /// By how much the standard deviation of each fitted nuisance exceeds what the fit
  /// states, at least 1, in their order.
  const Eigen::VectorXd& of_nuisances() const { return of_nuisances_; }

 private:
  struct Reading {
    Eigen::Index row = 0;
    double steps = 0;  ///< Since the one before it, in usual steps of its stream.
  };
  using Stream = std::vector<Reading>;
  struct World {
    double tau_steps = 0;
    double share = 0;
    double scale2 = 1;  ///< s^2
    double weight = 0;
  };

  void FindStreams(const Observed& observed, const std::vector<bool>& left_out);
  bool HangsTogether(const Eigen::VectorXd& residual) const;
  /// How likely each world is; worlds_[0] is the fit's own noise. `still`, `as_fitted`:
  /// log likelihood of white noise and of the fit's own.
  void Weigh(const Eigen::MatrixXd& columns, double still, double as_fitted);
  /// Columns made independent, in place; log of the correlation's determinant.
  double Whiten(const World& world, Eigen::MatrixXd* columns) const;
  /// Log restricted likelihood of the last column; the others, in units of their
  /// priors, are fitted. Sets the world's scale.
  double LogLikelihood(const Eigen::MatrixXd& columns, World* world) const;
  /// By column: how much the standard deviation of a sum of rows (in sigma) grows over
  /// that of the fit's own noise, whose variance is `own`.
  Eigen::VectorXd Inflation(const Eigen::MatrixXd& weights,
                            const Eigen::VectorXd& own) const;
  /// weights' E weights of each column, E = exp(-dt / tau).
  Eigen::VectorXd Faded(double tau_steps, const Eigen::MatrixXd& weights) const;

  std::vector<Stream> streams_{};
  std::vector<World> worlds_{};
  Eigen::VectorXd of_nuisances_{};
};

}  // namespace caltwin

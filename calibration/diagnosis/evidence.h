#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "calibration/diagnosis/noise.h"
#include "calibration/diagnosis/nuisances.h"
#include "calibration/diagnosis/observed.h"
#include "sim/base/dense.h"

namespace caltwin {

/// A set of columns as the evidence sees them: white, and what of them the baseline
/// cannot imitate.
///
///   gram = (W Phi)' M (W Phi),   match = (W Phi)' M (W r)
struct Projected {
  Eigen::MatrixXd gram{};
  Eigen::VectorXd match{};
};

/// One table of rows under one noise, its baseline projected out.
///
/// Nuisances have normal priors (wide ones for the baseline), which enter as one pseudo
/// reading each, so nothing is ever rank deficient. M projects out what they explain.
class Evidence {
 public:
  Evidence(const Observed& observed,
           const Noise& noise,
           const std::vector<Nuisance>& nuisances,
           const std::vector<bool>& left_out = {});

  /// Residual sum of squares r' W M W r, and its degrees of freedom.
  double chi2() const { return chi2_; }
  double dof() const { return dof_; }
  /// Restricted log likelihood of the rows without any candidate, the common scale of
  /// the noise integrated out; comparable between noises of the same rows.
  double log_none() const { return log_none_; }

  Eigen::MatrixXd Whiten(const Eigen::MatrixXd& columns_mm) const;
  Projected Project(const Eigen::MatrixXd& white) const;
  /// The same of many sets of columns [mm] at once: one product where each alone would
  /// read the whole baseline again.
  std::vector<Projected> ProjectEach(
      std::span<const Eigen::MatrixXd* const> sets_mm) const;
  /// Of columns already white, with respect to other right-hand sides (n x draws).
  Eigen::MatrixXd ProjectedReadings(const Eigen::MatrixXd& white_readings) const;
  /// What of white columns is left (n x k), pseudo readings dropped.
  Eigen::MatrixXd Left(const Eigen::MatrixXd& white) const;
  const Eigen::VectorXd& white_residual() const { return white_residual_; }

  /// log of the Bayes factor against none, prior variances `prior` of the amplitudes in
  /// units of sigma^2:
  ///   -1/2 log|I + D A| - dof/2 log(1 - b' (D^-1 + A)^-1 b / chi2)
  double LogBayes(const Projected& projected, const Eigen::VectorXd& prior) const;

  /// Posterior of the nuisances, in their units.
  struct Fit {
    Eigen::VectorXd values{};
    Eigen::VectorXd sds{};
    Eigen::VectorXd residual_mm{};  ///< Reading less model, by row.
    /// What the nuisances leave open of each row, whether it was fitted or left out.
    Eigen::VectorXd sd_mm{};
    Eigen::MatrixXd half{};  ///< Covariance of `values` = half half'.
  };
  Fit FitNuisances() const;

  /// Each row as the rows of all other groups foretell it, with nothing fitted again:
  ///   residual  e + Q_g (I - Q_g' Q_g)^-1 Q_g' e   of the group's residuals e,
  ///   variance  the diagonal of  Q_g (I - Q_g' Q_g)^-1 Q_g'
  /// (the Sherman-Morrison-Woodbury identity on the rows of a group). Rows of group -1
  /// are always fitted and come back as fitted. For a noise without wander.
  struct Foretold {
    Eigen::VectorXd residual_mm{};  ///< Reading less what was foretold.
    Eigen::VectorXd sd_mm{};  ///< Of what was foretold, for the noise as it is stated.
  };
  Foretold Foretell(const std::vector<int>& group_of) const;

 private:
  /// Orthonormal, rows by nuisances (pseudo rows dropped). Dear, and not asked for by
  /// most: made at the first call.
  const Eigen::MatrixXd& Q() const;
  Projected ProjectPart(const Eigen::Ref<const Eigen::MatrixXd>& white,
                        const Eigen::Ref<const Eigen::MatrixXd>& along) const;

  const Observed* observed_;
  Whitener whitener_;
  Eigen::VectorXd keep_;  ///< 0 for rows left out.
  Eigen::VectorXd sigma_mm_;
  Eigen::MatrixXd columns_mm_;
  Eigen::VectorXd prior_sd_;
  QrOf qr_;  ///< White columns above the priors.
  mutable Eigen::MatrixXd q_;
  Eigen::VectorXd white_residual_;
  Eigen::VectorXd taken_;  ///< What each nuisance takes of the residual.
  double chi2_ = 0, dof_ = 0, log_none_ = 0;
};

/// The same without an `Evidence`: for a right-hand side of its own. Columns explain at
/// most what leaves half of the noise, dof / 2.
double LogBayesOf(const Projected& projected,
                  const Eigen::VectorXd& prior,
                  double chi2,
                  double dof);

}  // namespace caltwin

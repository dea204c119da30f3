#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "calibration/estimate/uncertain.h"
#include "calibration/kinds/delta/bench.h"
#include "sim/machine/kinds/delta/knobs.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {

/// Everything measured on a delta. Motor travels are what settings and belts make of
/// steps: commanded mm down from the endstops.
struct DeltaReadings {
  std::vector<DeltaTouch> touches{};
  std::vector<DeltaDistance> distances{};
  std::vector<DeltaRodLength> rods{};
};

/// What a joint estimate asks for.
struct DeltaJointOptions {
  std::vector<int> knobs = FirmwareKnobs();
  /// Standard deviations of the priors in the knobs' units, by index of kDeltaKnobs;
  /// empty: as kDeltaKnobs has them. Infinite: none.
  std::vector<double> prior_sd{};
  /// What is believed beforehand, in the knobs' units, by index of kDeltaKnobs; empty:
  /// built as drawn.
  std::vector<double> prior_mean{};
  /// Readings further than this many sigma count less (Huber); 0: never.
  double huber_sigma = 3;
};

/// One unknown as estimated.
struct DeltaEstimate {
  int knob = 0;
  double value = 0;  ///< In the knob's unit, built less drawn.
  double sd = 0;
  /// Its sd over its prior's: near 1 the readings said nothing.
  double sd_over_prior = 0;
  /// Touches, lengths of a print, rods by calliper, priors by name.
  std::vector<Contribution> budget{};
};

/// The machine that fits best, how sure that is, and what it foretells.
struct DeltaJointFit {
  bool converged = false;
  int rounds = 0;
  DeltaBuild<double> build{};
  DeltaBed<double> bed{};
  std::vector<DeltaEstimate> estimates{};  ///< As asked for.
  Eigen::MatrixXd covariance{};            ///< Of the estimates, in inside values.
  double rms_mm = 0;                       ///< Of the heights fitted.
  double hold_out_mm = 0;  ///< Of heights left out one by one (exact for a linear fit).
  double chi2_per_dof = 0;
  /// The direction in units of the priors that the readings tell least of, with its
  /// standard deviation there.
  std::vector<double> weakest{};
  double weakest_sd = 0;
};

/// Least squares with priors of all unknowns over all readings, through the exact
/// six-rod chain with exact derivatives (Levenberg-Marquardt; Huber's weights).
///
///   residual = (nozzle height over the bed - height) / sigma,
///   (distance of two places of the nozzle - distance) / sigma,
///   (rod as the machine has it - rod) / sigma
///
/// A rod length says what it says even where no knob turns that rod: then all of a
/// tower's readings pull at `arm_length`, which cannot follow unlike rods.
DeltaJointFit FitDeltaJointly(const DeltaBuild<double>& drawn,
                              const DeltaReadings& readings,
                              const DeltaJointOptions& options = {});

/// Slopes of the nozzle's height over a level bed by these knobs' inside values, a row
/// a place of the motors; not finite where the machine does not reach.
Eigen::MatrixXd HeightSlopes(const DeltaBuild<double>& build,
                             const std::vector<Vec3<double>>& motors_mm,
                             const std::vector<int>& knobs);

/// Height of the nozzle over the bed at these motor travels as a fit foretells it, and
/// how sure that is [mm].
struct DeltaForetold {
  double height_mm = 0;
  double sd_mm = 0;
};
DeltaForetold ForetellHeight(const DeltaJointFit& fit, const Vec3<double>& motors_mm);

/// Of the points of a lattice on the disc, the touch after which the heights all over
/// it are surest (least mean variance); `settings` lead there.
Vec3<double> BestNextTouch(const DeltaJointFit& fit,
                           const DeltaModel<double>& settings,
                           double radius_mm,
                           double sigma_mm);

}  // namespace caltwin

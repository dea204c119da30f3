#pragma once

#include <vector>

#include <Eigen/Core>

#include "calibration/diagnosis/weighing.h"

namespace caltwin {

/// A row further than this from everything that fits is an outlier.
inline constexpr double kOutlier_sigma = 4.2;

/// The richest model: baseline, the likeliest causes and the likeliest free forms all
/// at once, each held back by its prior. What it leaves is noise, whatever is there.
struct Richest {
  Eigen::VectorXd residual_mm{};   ///< Reading less model.
  Eigen::VectorXd leverage{};      ///< How much of its own residual a row takes away.
  std::vector<double> sigma_mm{};  ///< By campaign: rms over degrees of freedom.
  std::vector<double> dof{};       ///< By campaign.
  std::vector<bool> is_outlier{};  ///< Beyond 4.2 sigma, as if it had been left out.
};

/// Judges rows against the richest model; outliers are found one by one, the farthest
/// first, and never more than a twentieth of the rows. `suspects` take no part at all:
/// several bad rows would hide each other.
Richest JudgeRows(const Observed& observed,
                  const std::vector<Candidate>& candidates,
                  const Weighing& weighing,
                  const Circumstances& circumstances,
                  const std::vector<bool>& suspects);

/// Rows that contradict their own replicates (same pose, sense and circumstances; four
/// of them or more) by ten times what these scatter by, and stand alone: three of a
/// campaign at most, since what shows in more may be a cause. No model takes part, so
/// none can be bent to pass through them.
std::vector<bool> LoneRows(const Observed& observed);

}  // namespace caltwin

#pragma once

#include <vector>

#include <Eigen/Core>

#include "calibration/diagnosis/nuisances.h"
#include "calibration/diagnosis/observed.h"

namespace caltwin {

/// The baseline alone, all rows counting alike but those far out, which count for
/// nothing. `found` as in AtBaseline.
struct FittedBaseline {
  Eigen::VectorXd left_mm{};  ///< Reading less fit, by row.
  /// What the rows tell well enough to be linear about.
  BaselinePoint point{};
};
FittedBaseline FitBaseline(const Observed& observed,
                           const std::vector<Nuisance>& found = {});

/// The rows as the baseline has them: touches taken where it says that they trigger,
/// rows read inside a gap with the sense they have there, pre-travel as large as it is
/// in each direction. In rounds, since what decides upon rows is fitted to them.
/// `found`: what the rows show beside the baseline, by column; without it the baseline
/// would take part of it.
Observed AtBaseline(const Observed& as_read, const std::vector<Nuisance>& found = {});

/// The rows of a delta once more, its knobs turned by what a baseline was fitted to
/// `at`; `left_mm` is what that fit left. Elsewhere just `at`.
Observed TurnedBy(const Observed& as_read,
                  const Observed& at,
                  const std::vector<Nuisance>& baseline,
                  const Eigen::VectorXd& values,
                  const Eigen::VectorXd& left_mm);

/// Whether two baselines of the same rows are about points that differ enough to
/// matter.
bool AreApart(const Observed& one, const Observed& other);

}  // namespace caltwin

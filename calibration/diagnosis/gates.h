#pragma once

#include <cstddef>
#include <optional>

#include <Eigen/Core>

#include "calibration/diagnosis/candidates.h"
#include "calibration/diagnosis/evidence.h"
#include "calibration/diagnosis/weighing.h"

namespace caltwin {

/// Which rows a candidate owes its evidence to.
struct Support {
  /// It stands without the three rows that speak most for it: likelier than not, and
  /// three tenths of its size at least.
  bool is_by_many = false;
  /// A row beyond 4.2 sigma that speaks for it louder than all others together.
  std::optional<std::size_t> loudest{};
};
Support SupportOf(const Observed& observed,
                  const Circumstances& circumstances,
                  double wander_mm2_per_s,
                  const Candidate& candidate,
                  const Weighed& weighed);

/// How much of what was found is the deviation from the cause's form, its near-peak
/// over that of the rest: as fitted, or, where less, the part that no other form and
/// size of the cause could be, in sigma, the baseline taken out of both.
double FormShare(const Evidence& evidence,
                 const Candidate& candidate,
                 const Weighed& weighed);

/// lambda_sep: how far a fitted effect (white) is from what a rival could do instead,
/// the square of sigmas between both.
double Separation(const Evidence& evidence,
                  const Eigen::VectorXd& effect_white,
                  const Candidate& rival);

}  // namespace caltwin

#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "calibration/diagnosis/candidates.h"
#include "calibration/diagnosis/weighing.h"

namespace caltwin {

/// A rival of a finding.
struct Rival {
  std::size_t candidate = 0;
  double probability = 0;
  /// It could imitate the finding in these rows, whatever its probability.
  bool structural = false;
  double separation = 0;  ///< lambda_sep; the square of sigmas between both.

  bool operator==(const Rival&) const = default;
};

/// One cause found, before refinement.
struct Found {
  std::size_t candidate = 0;
  Variant variant{};
  Eigen::VectorXd sizes_mm{};
  double probability = 0;
  double log_odds = 0;
  double scale_mm = 0;
  bool lost_its_name = false;  ///< Deviates too far from its form: unknown.
  /// A sibling explains what it deviates by (the same cause by another thermometer): it
  /// has no freedom of form.
  bool keeps_its_form = false;
  std::vector<Rival> rivals{};
  int num_rows = 0;  ///< That it rests on.
};

/// The free form in the variables of a finding that lost its name, in its place; the
/// finding itself where no free form has them. `circumstances`: the others found in the
/// baseline.
Found FreeInstead(const Observed& observed,
                  const std::vector<Candidate>& candidates,
                  const Circumstances& circumstances,
                  const Found& found);

/// Whether it is a table of an axis that moves it by less than a motor step: what
/// stands at whole steps errs by a part of one, at each position the same.
bool IsFinerThanAStep(const Observed& observed,
                      const std::vector<Candidate>& candidates,
                      const Found& found);

/// What a finding adds to the nuisances while others are sought: its own sizes, free,
/// and its freedom of form.
std::vector<Nuisance> NuisancesOf(const Observed& observed,
                                  const Candidate& candidate,
                                  const Found& found);

/// The same of all that was found, or of all but one.
std::vector<Nuisance> NuisancesOfAll(const Observed& observed,
                                     const std::vector<Candidate>& candidates,
                                     const std::vector<Found>& found,
                                     std::optional<std::size_t> except = {});

}  // namespace caltwin

#pragma once

#include <vector>

#include <Eigen/Core>

#include "calibration/diagnosis/search.h"

namespace caltwin {

/// A named finding with its parameters refined: what is injected into the extended
/// machine, and how sure each value is.
struct Refined {
  Injected effect{};
  std::vector<double> sds{};  ///< As declared, in the same units.
  Variant variant{};          ///< At the refined forms.
  Eigen::VectorXd sizes_mm{};
  Eigen::MatrixXd half_mm{};  ///< Of a table: covariance of `sizes_mm` = half half'.
};

/// Refines the named findings together: their form parameters by Ceres over the
/// projected residual (sizes and baseline are solved exactly for every trial), then
/// sizes, phases and forms with their covariance from the linearised problem, freedom
/// of form included. What is not straight in its sizes is fitted to the exact
/// prediction (Bend). Free forms keep their columns; their sizes are fitted beside the
/// names, with the freedom by which their gain is stated. One entry per finding; a free
/// one has no effect (index -1) and no variant.
std::vector<Refined> Refit(const Observed& observed,
                           const std::vector<Candidate>& candidates,
                           const SearchResult& search);

}  // namespace caltwin

#pragma once

#include <string>
#include <vector>

#include "calibration/diagnosis/refit.h"
#include "calibration/diagnosis/search.h"

namespace caltwin {

/// How well rows are predicted that were not fitted [mm rms]. Only rows that the rest
/// tells the baseline of count: a setup's offset cannot be foretold.
struct HeldOut {
  double before_mm = 0;  ///< Baseline alone.
  double after_mm = 0;   ///< With the findings.
  int rows = 0;
  int groups = 0;
};

struct GainFigures {
  HeldOut blocks{};  ///< Contiguous times left out inside each setup.
  HeldOut
      runs{};  ///< Repetitions left out: gain where it was measured. 0 groups: none.
  HeldOut positions{};  ///< Positions left out: gain between them. 0 groups: none.
  double noise_floor_mm = 0;
  bool floor_from_replicates = false;
  /// (before^2 - after^2) / (before^2 - floor^2) of `blocks`.
  double explained_fraction = 0;
  /// Share of each finding in the explainable variance, Shapley; what is missing to 1
  /// remains unexplained.
  std::vector<double> shares{};
  /// By how much each finding, beside the others, makes rows left out (blocks) more
  /// likely: sum over rows of log p(row | rest, with) - log p(row | rest, without),
  /// each row as far as five sigmas. Unlike rms, it knows how far a row is from what is
  /// left, and minds no outlier [nats].
  std::vector<double> scores{};
};

GainFigures GainOf(const Observed& observed,
                   const std::vector<Candidate>& candidates,
                   const SearchResult& search,
                   const std::vector<Refined>& refined);

}  // namespace caltwin

#pragma once

#include <cstdint>
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
  /// Inner positions left out in turn: gain between them. 0 groups: none. The size of a
  /// table's prior is chosen without the rows left out.
  HeldOut positions{};
  /// The same with the size that all rows chose: how well the table, as it is, stands
  /// between its positions. A name rests on this, a promise on `positions`.
  HeldOut positions_as_fitted{};
  HeldOut ends{};  ///< The same of the first and last position: an extrapolation.
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

/// What a gain is asked for: what decides on findings, or all that is reported.
enum class GainDepth : std::uint8_t { kBlocks, kAll };

/// @param depth  kBlocks: without `runs`, `positions` and `ends`
GainFigures GainOf(const Observed& observed,
                   const std::vector<Candidate>& candidates,
                   const SearchResult& search,
                   const std::vector<Refined>& refined,
                   GainDepth depth = GainDepth::kAll);

}  // namespace caltwin

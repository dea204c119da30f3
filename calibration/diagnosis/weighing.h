#pragma once

#include <cstddef>
#include <map>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "calibration/diagnosis/candidates.h"
#include "calibration/diagnosis/evidence.h"

namespace caltwin {

/// What the rows say of one candidate, beside the baseline and what is already found.
struct Weighed {
  std::size_t candidate = 0;  ///< Index in the list weighed.
  std::size_t variant = 0;    ///< The best of its variants.
  /// log posterior odds against none, prior included.
  double log_odds = -1e300;
  double probability = 0;          ///< Among all candidates and none.
  double scale_mm = 0;             ///< The most likely prior size.
  Eigen::VectorXd sizes_mm{};      ///< Posterior mean of its sizes.
  Eigen::VectorXd deviation_mm{};  ///< Posterior mean of its deviation from form.
};

/// All candidates, the likeliest first.
struct Weighing {
  std::vector<Weighed> ranked{};
  double log_odds_any = -1e300;  ///< That anything at all is there.
  /// The wander that is most likely when nothing else is there [mm^2/s].
  double wander_mm2_per_s = 0;
};

/// What a weighing is made under.
struct Circumstances {
  Eigen::VectorXd sigma_mm{};
  std::vector<Nuisance> nuisances{};
  std::vector<bool> left_out{};
};

/// Freedom of form of the variants of one list of candidates, each made when it is
/// first asked for: it depends on the rows' places alone, and many weighings ask for
/// the same.
class Tolerances {
 public:
  /// Both must outlive this.
  Tolerances(const Observed& observed, const std::vector<Candidate>& candidates)
      : observed_(observed), candidates_(candidates) {}

  const Tolerance& Of(std::size_t candidate, std::size_t variant);

 private:
  const Observed& observed_;
  const std::vector<Candidate>& candidates_;
  std::map<std::pair<std::size_t, std::size_t>, Tolerance> made_{};
};

/// Weighs every candidate: averaged over its variants, over a grid of sizes, over the
/// rates of wander that the rows allow; with freedom of form for the best variants.
/// @param tolerances  of the same rows and candidates; null: made for this weighing
Weighing Weigh(const Observed& observed,
               const std::vector<Candidate>& candidates,
               const Circumstances& circumstances,
               Tolerances* tolerances = nullptr);

/// The fastest wander that is tried: variance gained per second.
double MostWander_mm2_per_s();

/// The same without its likeliest candidate.
void DropLikeliest(Weighing* weighing);

/// The prior size of a variant that is most likely under this evidence, of those that a
/// weighing averages over.
double LikeliestScale_mm(const Evidence& evidence,
                         const Candidate& candidate,
                         const Variant& variant);

/// Chance that rows of noise alone, with this baseline, would reach `log_odds_any`: the
/// largest of a hundred simulated weighings, their tail extrapolated as exponential.
double ChanceUnderNone(const Observed& observed,
                       const std::vector<Candidate>& candidates,
                       const Circumstances& circumstances,
                       double wander_mm2_per_s,
                       double log_odds_any,
                       std::uint64_t seed);

/// log sum exp, ignoring nothing.
double LogSum(const std::vector<double>& logs);

}  // namespace caltwin

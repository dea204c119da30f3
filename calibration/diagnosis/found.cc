#include "calibration/diagnosis/found.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "calibration/diagnosis/free_form.h"
#include "calibration/diagnosis/kinds/diagnosed_kind.h"
#include "sim/effects/drive.h"

namespace caltwin {
namespace {

// A finding's own sizes are free: this many times what was found.
constexpr double kFree = 30;

}  // namespace

Found FreeInstead(const Observed& observed,
                  const std::vector<Candidate>& candidates,
                  const Circumstances& circumstances,
                  const Found& found) {
  const Shown& shown = candidates[found.candidate].shown;
  std::set<std::string> words(shown.covariates.begin(), shown.covariates.end());
  std::erase_if(words, [&](const auto& word) { return IsSliver(observed, word); });
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    const Candidate& free = candidates[c];
    if (!free.is_free() || free.shown.channel != shown.channel) continue;
    if (words != std::set<std::string>(free.shown.covariates.begin(),
                                       free.shown.covariates.end())) {
      continue;
    }
    const Weighed weighed = Weigh(observed, {free}, circumstances).ranked[0];
    Found instead = found;
    instead.candidate = c;
    instead.variant = free.variants[0];
    instead.sizes_mm = weighed.sizes_mm;
    instead.scale_mm = weighed.scale_mm;
    instead.lost_its_name = false;
    instead.rivals.clear();
    return instead;
  }
  return found;
}

bool IsFinerThanAStep(const Observed& observed,
                      const std::vector<Candidate>& candidates,
                      const Found& found) {
  const Candidate& candidate = candidates[found.candidate];
  const auto drive = DriveNamed(candidate.shown.channel);
  if (!candidate.is_free() || !drive) return false;
  const int motor = DiagnosedAs(observed.machine()).AxisOfMotor(*drive);
  return Peak_mm(found.variant.columns_mm * found.sizes_mm) <
         1 / observed.machine().axes[static_cast<std::size_t>(motor)].steps_per_mm();
}

std::vector<Nuisance> NuisancesOf(const Observed& observed,
                                  const Candidate& candidate,
                                  const Found& found) {
  std::vector<Nuisance> nuisances;
  const double size_mm = std::max(found.sizes_mm.norm(), found.scale_mm);
  const auto add = [&](const Eigen::VectorXd& column, double prior_sd) {
    nuisances.push_back({.name = candidate.Name(),
                         .unit = "mm",
                         .column_mm = column,
                         .prior_sd = prior_sd,
                         .reported = false});
  };
  for (Eigen::Index k = 0; k < found.variant.columns_mm.cols(); ++k) {
    const double relative =
        candidate.is_free() ? std::sqrt(candidate.free_prior[k]) : kFree;
    add(found.variant.columns_mm.col(k),
        candidate.is_free() ? 3 * found.scale_mm * relative : size_mm * kFree);
  }
  if (found.keeps_its_form) return nuisances;
  const Tolerance tolerance = ToleranceOf(observed, candidate, found.variant);
  const double freedom = found.lost_its_name ? 3 : 1;
  for (Eigen::Index k = 0; k < tolerance.columns_mm.cols(); ++k) {
    // A fifth of what it does, not of what it might do.
    add(tolerance.columns_mm.col(k),
        freedom * found.sizes_mm.norm() * std::sqrt(tolerance.prior[k]));
  }
  return nuisances;
}

std::vector<Nuisance> NuisancesOfAll(const Observed& observed,
                                     const std::vector<Candidate>& candidates,
                                     const std::vector<Found>& found,
                                     std::optional<std::size_t> except) {
  std::vector<Nuisance> all;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (i == except) continue;
    const auto more = NuisancesOf(observed, candidates[found[i].candidate], found[i]);
    all.insert(all.end(), more.begin(), more.end());
  }
  return all;
}

}  // namespace caltwin

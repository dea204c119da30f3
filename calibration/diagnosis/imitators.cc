#include "calibration/diagnosis/imitators.h"

#include <algorithm>

#include "calibration/diagnosis/gates.h"
#include "calibration/diagnosis/own_shape.h"

namespace caltwin {
namespace {

constexpr double kImitates = 9;

// Where every row before a jump lies on one side of every row after it, a step in the
// axis' own scale is as likely as steps lost at that time.
void AddPlace(const Observed& observed,
              const std::vector<Candidate>& candidates,
              Found* found) {
  const Candidate& own = candidates[found->candidate];
  if (!IsPlaceAsWell(observed, own, found->variant)) return;
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    const Shown& shown = candidates[c].shown;
    const bool is_place = candidates[c].is_free() &&
                          shown.channel == own.shown.channel &&
                          shown.covariates == std::vector{shown.channel};
    if (!is_place) continue;
    std::erase_if(found->rivals, [&](const Rival& r) { return r.candidate == c; });
    found->probability /= 2;
    found->rivals.push_back({.candidate = c, .probability = found->probability});
  }
}

}  // namespace

void AddImitators(const Observed& observed,
                  const std::vector<Candidate>& candidates,
                  const Evidence& beside,
                  std::size_t finding,
                  std::vector<Found>* found) {
  Found& own = (*found)[finding];
  const Eigen::VectorXd effect = beside.Whiten(own.variant.columns_mm * own.sizes_mm);
  // Beside the freedom of form of the others little may be visible; an imitation
  // shows half of that at least.
  constexpr double kMostLeft = 0.5;
  const Eigen::VectorXd left = beside.Left(effect);
  const double visible = effect.dot(left) / (beside.chi2() / beside.dof());
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    const bool is_found =
        std::ranges::find(*found, c, &Found::candidate) != found->end();
    if (is_found || candidates[c].is_free()) continue;
    const double separation = Separation(beside, effect, candidates[c]);
    if (separation >= kImitates || separation > kMostLeft * visible) continue;
    auto known = std::ranges::find(own.rivals, c, &Rival::candidate);
    if (known == own.rivals.end()) {
      known = own.rivals.insert(own.rivals.end(), {.candidate = c});
    }
    known->structural = true;
    known->separation = separation;
  }
  AddPlace(observed, candidates, &own);
  std::ranges::stable_sort(own.rivals, std::ranges::greater{}, &Rival::probability);
}

}  // namespace caltwin

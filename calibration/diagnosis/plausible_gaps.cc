// Whether campaigns agree on how much an axis loses at its reversals.

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "calibration/diagnosis/plausible_parts.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

/// The gap that a campaign's gauge shows along an axis.
struct Gap {
  std::string campaign{}, settings{};
  int axis = 0;
  double half_mm = 0, sd_mm = 0;
};

// The same axis has one gap: one that is 25.4 or 1000 times another's is a unit.
void CompareGaps(const std::vector<Gap>& gaps, std::vector<Doubt>* doubts) {
  constexpr double kSure = 5, kSeen = 3, kAlike = 0.15;
  for (const Gap& large : gaps) {
    for (const Gap& small : gaps) {
      const bool both_seen = std::abs(large.half_mm) > kSure * large.sd_mm &&
                             std::abs(small.half_mm) > kSeen * small.sd_mm;
      if (large.axis != small.axis || !both_seen) continue;
      const double ratio = large.half_mm / small.half_mm;
      const bool is_inch = std::abs(ratio / MmFromInch(1.0) - 1) < kAlike;
      if (!is_inch && std::abs(ratio / UmFromMm(1.0) - 1) > kAlike) continue;
      doubts->push_back(
          {.kind = "units_differ",
           .message =
               fmt::format("{} has lost {:.3g} um at its reversals in campaign {} "
                           "and {:.3g} um in campaign {}",
                           "xyz"[large.axis],
                           UmFromMm(-2 * large.half_mm),
                           large.campaign,
                           UmFromMm(-2 * small.half_mm),
                           small.campaign),
           .hint = is_inch ? "that is an inch: value_mm of the second is in inches"
                           : "that is 1000: one of them is in other units",
           .refuse = true});
    }
  }
}

// Lost motion lags, and compensation that does too much leads in every campaign: under
// one setting no gap can do both.
void CompareSenses(const std::vector<Gap>& gaps, std::vector<Doubt>* doubts) {
  constexpr double kSure = 5, kAlike = 3;
  const auto is_sure = [&](const Gap& gap) {
    return std::abs(gap.half_mm) > kSure * gap.sd_mm;
  };
  for (const Gap& lagging : gaps) {
    for (const Gap& leading : gaps) {
      const bool contradict = lagging.half_mm < 0 && leading.half_mm > 0 &&
                              lagging.axis == leading.axis &&
                              lagging.settings == leading.settings;
      if (!contradict || !is_sure(lagging) || !is_sure(leading)) continue;
      const double ratio = -lagging.half_mm / leading.half_mm;
      if (ratio > kAlike || ratio < 1 / kAlike) continue;
      doubts->push_back(
          {.kind = "reversed_sign",
           .message = fmt::format(
               "{0} lags by {1:.3g} um at its reversals in campaign {2} and leads by "
               "{3:.3g} um in campaign {4}",
               "xyz"[lagging.axis],
               UmFromMm(-2 * lagging.half_mm),
               lagging.campaign,
               UmFromMm(2 * leading.half_mm),
               leading.campaign),
           .hint =
               fmt::format("one gap cannot do both: in one of them value_mm or dir_{} "
                           "has the other sign, most likely in {}",
                           "xyz"[lagging.axis],
                           leading.campaign),
           .refuse = true});
      return;
    }
  }
}

}  // namespace

void DoubtGaps(const std::vector<RowSeries>& all, std::vector<Doubt>* doubts) {
  constexpr std::size_t kFewest = 5;
  std::vector<Gap> gaps;
  for (const RowSeries& series : all) {
    if (series.rows.size() < kFewest || series.first->kind == RowKind::kTouch) continue;
    // On machines whose motors are no axes a gap is a motor's, and each has its own.
    if (Known(series.first->motor_mm[0])) continue;
    const SeriesFit fit = FitSeries(series);
    if (!(fit.half_gap_sd_mm > 0)) continue;
    const std::array<double, 3>& n = series.first->n;
    const auto along = std::ranges::max_element(
        n, {}, [](double part) { return Known(part) ? std::abs(part) : 0; });
    gaps.push_back({series.first->campaign,
                    series.first->settings,
                    static_cast<int>(along - n.begin()),
                    fit.half_gap_mm,
                    fit.half_gap_sd_mm});
  }
  CompareGaps(gaps, doubts);
  CompareSenses(gaps, doubts);
}

}  // namespace caltwin

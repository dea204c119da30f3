#include "calibration/diagnosis/changes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "calibration/diagnosis/candidates.h"
#include "calibration/diagnosis/evidence.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kChanceOfAny = 0.01;
constexpr double kWide = 1e3;  // In times the finding itself: free.
constexpr double kLeastSigma_mm = 1e-6;

struct Size {
  double value = 0, sd = 0;
};

std::string NameOf(const Finding& finding) {
  return finding.axis.empty() ? finding.cause : finding.cause + "." + finding.axis;
}

// Each row takes its place anew in every campaign.
bool IsPlaced(const std::string& name) {
  return name.starts_with("placement.");
}

// How often a finding's shape stands in rows, as a multiple of itself: 1 in its own.
Size TimesIn(const Diagnosed& rows, const Finding& finding) {
  const Eigen::VectorXd shape_mm = rows.observed.Change_mm(*finding.effect);
  const double sigma_mm = std::max(rows.diagnosis.gain.noise_floor_mm, kLeastSigma_mm);
  std::vector<Nuisance> nuisances = BaselineOf(rows.observed);
  for (const Finding& other : rows.diagnosis.findings) {
    if (other.change_mm.size() != shape_mm.size() || NameOf(other) == NameOf(finding)) {
      continue;
    }
    nuisances.push_back({.name = NameOf(other),
                         .column_mm = other.change_mm,
                         .prior_sd = kWide,
                         .reported = false});
  }
  nuisances.push_back(
      {.name = NameOf(finding), .column_mm = shape_mm, .prior_sd = kWide});
  std::vector<bool> left_out(static_cast<std::size_t>(rows.observed.num_rows()));
  for (std::size_t i = 0; i < left_out.size(); ++i) {
    const auto number = rows.observed.row(static_cast<Eigen::Index>(i)).row;
    left_out[i] = std::ranges::find(rows.diagnosis.outlier_rows, number) !=
                  rows.diagnosis.outlier_rows.end();
  }
  const Eigen::VectorXd sigmas_mm =
      Eigen::VectorXd::Constant(rows.observed.num_rows(), sigma_mm);
  const Evidence::Fit fit =
      Evidence(rows.observed, {sigmas_mm, 0}, nuisances, left_out).FitNuisances();
  return {fit.values[fit.values.size() - 1], fit.sds[fit.sds.size() - 1]};
}

Change Of(std::string name, std::string unit, const Size& before, const Size& now) {
  const double sd = std::hypot(before.sd, now.sd);
  return {.name = std::move(name),
          .unit = std::move(unit),
          .before = before.value,
          .before_sd = before.sd,
          .now = now.value,
          .now_sd = now.sd,
          .sigmas = sd > 0 ? std::abs(now.value - before.value) / sd : 0};
}

void AddBaselines(const Diagnosis& before,
                  const Diagnosis& now,
                  std::vector<Change>* changes) {
  for (const BaselineLine& line : now.baseline) {
    const auto earlier =
        std::ranges::find(before.baseline, line.name, &BaselineLine::name);
    if (IsPlaced(line.name) || earlier == before.baseline.end()) continue;
    changes->push_back(
        Of(line.name, line.unit, {earlier->value, earlier->sd}, {line.value, line.sd}));
  }
}

// A finding of `home` in both; in peak micrometres.
Change OfFinding(const Finding& finding,
                 const Diagnosed& before,
                 const Diagnosed& now) {
  const auto peak = [&](const Diagnosed& rows) {
    const Size times = TimesIn(rows, finding);
    return Size{times.value * finding.peak_um, times.sd * finding.peak_um};
  };
  return Of(NameOf(finding), "um", peak(before), peak(now));
}

// Normal deviate exceeded in size once in 1 / chance times, by bisection.
double TwoSidedQuantile(double chance) {
  double low = 0, high = 10;
  while (high - low > 1e-6) {
    const double middle = (low + high) / 2;
    (std::erfc(middle / std::numbers::sqrt2) > chance ? low : high) = middle;
  }
  return high;
}

}  // namespace

std::vector<Change> ChangesSince(const Diagnosed& before, const Diagnosed& now) {
  std::vector<Change> changes;
  AddBaselines(before.diagnosis, now.diagnosis, &changes);
  std::vector<std::string> told;
  for (const Diagnosed* home : {&now, &before}) {
    for (const Finding& finding : home->diagnosis.findings) {
      const bool is_told = std::ranges::find(told, NameOf(finding)) != told.end();
      if (is_told || !finding.effect || finding.effect->effect < 0) continue;
      told.push_back(NameOf(finding));
      changes.push_back(OfFinding(finding, before, now));
    }
  }
  const auto count = static_cast<double>(std::max<std::size_t>(changes.size(), 1));
  const double limit = TwoSidedQuantile(kChanceOfAny / count);
  for (Change& change : changes) change.is_more_than_noise = change.sigmas > limit;
  return changes;
}

}  // namespace caltwin

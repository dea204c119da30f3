#include "calibration/diagnosis/changes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "calibration/diagnosis/as_found.h"
#include "calibration/diagnosis/baseline_fit.h"
#include "calibration/diagnosis/extension.h"
#include "calibration/diagnosis/time_noise.h"
#include "calibration/diagnosis/whole_tables.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kChanceOfAny = 0.01;
constexpr double kWide = 1e3;  // In times the finding itself: free.
constexpr double kSecondsPerHour = 3600;

// Each row takes its place anew in every campaign.
bool IsPlaced(const std::string& name) {
  return name.starts_with("placement.");
}

// What one finding does to rows that may not be those it was found in; empty: no model
// of it can be made for other rows.
Eigen::VectorXd ShapeIn(const Observed& rows, const Finding& finding) {
  if (const auto effect = EffectOf(finding)) return rows.Change_mm(*effect);
  const bool is_home = finding.change_mm.size() == rows.num_rows();
  return is_home ? finding.change_mm : Eigen::VectorXd{};
}

// Findings of both, each name once: of two the later one's shape.
std::vector<const Finding*> AllFindings(const Diagnosed& before, const Diagnosed& now) {
  std::vector<const Finding*> all;
  for (const Diagnosed* home : {&now, &before}) {
    for (const Finding& finding : home->diagnosis.findings) {
      const bool is_told = std::ranges::any_of(
          all, [&](const Finding* other) { return KeyOf(*other) == KeyOf(finding); });
      if (!is_told) all.push_back(&finding);
    }
  }
  return all;
}

std::vector<Nuisance> ShapesIn(const Observed& rows,
                               const std::vector<const Finding*>& findings) {
  std::vector<Nuisance> shapes;
  for (const Finding* finding : findings) {
    const Eigen::VectorXd shape_mm = ShapeIn(rows, *finding);
    if (shape_mm.size() == 0) continue;
    shapes.push_back(
        {.name = KeyOf(*finding), .column_mm = shape_mm, .prior_sd = kWide});
  }
  return shapes;
}

struct Size {
  double value = 0, sd = 0;
  bool is_determined = false;
};

/// One campaign's figures, by name: of the baseline in their units, of findings as
/// multiples of themselves.
using Sizes = std::map<std::string, Size>;

// Everything fitted together; how sure, from the scatter of the rows, and from how what
// is left hangs together in time.
Sizes SizesIn(const Diagnosed& of, const std::vector<const Finding*>& findings) {
  const Observed rows = AtBaseline(of.observed, ShapesIn(of.observed, findings));
  std::vector<Nuisance> all = BaselineOf(rows);
  const auto more = ShapesIn(rows, findings);
  all.insert(all.end(), more.begin(), more.end());
  std::vector<bool> left_out(static_cast<std::size_t>(rows.num_rows()));
  for (std::size_t i = 0; i < left_out.size(); ++i) {
    const auto number = rows.row(static_cast<Eigen::Index>(i)).row;
    left_out[i] = std::ranges::find(of.diagnosis.outlier_rows, number) !=
                  of.diagnosis.outlier_rows.end();
  }
  const double wander_mm = MmFromUm(of.diagnosis.wander_um_per_sqrt_h);
  const Noise noise{of.diagnosis.sigma_mm, wander_mm * wander_mm / kSecondsPerHour};
  const Evidence::Fit fit = Evidence(rows, noise, all, left_out).FitNuisances();
  const TimeNoise time(rows, noise, all, left_out);
  Sizes sizes;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k);
    const double sd = fit.sds[at] * time.of_nuisances()[at];
    sizes[all[k].name] = {.value = all[k].offset + fit.values[at],
                          .sd = sd,
                          .is_determined = IsDetermined(all[k], sd)};
  }
  return sizes;
}

Size SizeOf(const Sizes& sizes, const std::string& name, double unit) {
  const auto found = sizes.find(name);
  if (found == sizes.end()) return {};
  Size size = found->second;
  size.value *= unit;
  size.sd *= unit;
  return size;
}

// A line of the baseline, no surer than its diagnosis states it beside the freedom of
// form of what was found there.
Size LineOf(const Diagnosis& diagnosis, const Sizes& sizes, const std::string& name) {
  Size size = SizeOf(sizes, name, 1);
  const auto line = std::ranges::find(diagnosis.baseline, name, &BaselineLine::name);
  if (line != diagnosis.baseline.end()) size.sd = std::max(size.sd, line->sd);
  return size;
}

// A finding's peak, relatively no surer than its size was stated where it was found.
Size PeakOf(const Sizes& sizes, const Finding& finding) {
  Size size = SizeOf(sizes, KeyOf(finding), finding.peak_um);
  if (!finding.effect) return size;
  const auto parameters = EffectAt(finding.effect->effect).parameters;
  for (std::size_t p = 0; p < std::min(parameters.size(), finding.sds.size()); ++p) {
    const double value = std::abs(finding.effect->values[p]);
    if (parameters[p].role != Role::kSize || value == 0) continue;
    size.sd = std::max(size.sd, std::abs(size.value) * finding.sds[p] / value);
  }
  return size;
}

Change Of(std::string name, std::string unit, const Size& before, const Size& now) {
  const double sd = std::hypot(before.sd, now.sd);
  const bool is_told = before.is_determined && now.is_determined && sd > 0;
  return {.name = std::move(name),
          .unit = std::move(unit),
          .before = before.value,
          .before_sd = before.sd,
          .now = now.value,
          .now_sd = now.sd,
          .sigmas = is_told ? std::abs(now.value - before.value) / sd : 0,
          .before_is_determined = before.is_determined,
          .now_is_determined = now.is_determined};
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
  const std::vector<const Finding*> findings = AllFindings(before, now);
  const Sizes earlier = SizesIn(before, findings), later = SizesIn(now, findings);
  std::vector<Change> changes;
  for (const BaselineLine& line : now.diagnosis.baseline) {
    if (IsPlaced(line.name) || !earlier.contains(line.name)) continue;
    changes.push_back(Of(line.name,
                         line.unit,
                         LineOf(before.diagnosis, earlier, line.name),
                         LineOf(now.diagnosis, later, line.name)));
  }
  for (const Finding* finding : findings) {
    const std::string name = KeyOf(*finding);
    changes.push_back(
        Of(name, "um", PeakOf(earlier, *finding), PeakOf(later, *finding)));
  }
  const auto count = std::ranges::count_if(changes, &Change::IsCompared);
  const double comparisons = std::max(static_cast<double>(count), 1.0);
  const double limit = TwoSidedQuantile(kChanceOfAny / comparisons);
  for (Change& change : changes) change.is_more_than_noise = change.sigmas > limit;
  return changes;
}

}  // namespace caltwin

#include "calibration/facts/map_change.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <fmt/format.h>

#include "calibration/facts/height_maps.h"
#include "calibration/facts/levels.h"
#include "sim/base/dense.h"
#include "sim/base/units.h"
#include "sim/base/with_sd.h"

namespace caltwin {
namespace {

/// Changes and where: columns 1, u, v.
struct Change {
  Eigen::MatrixXd columns{};
  Eigen::VectorXd change_mm{};
};

Change ChangeOf(const HeightMap& before, const HeightMap& now) {
  std::vector<std::array<double, 3>> all;
  for (const auto& [place, rows] : now) {
    const auto then = before.find(place);
    if (then != before.end())
      all.push_back({static_cast<double>(place.first),
                     static_cast<double>(place.second),
                     MeanOf(rows) - MeanOf(then->second)});
  }
  const auto num = std::ssize(all);
  Change change{Eigen::MatrixXd::Ones(num, 3), Eigen::VectorXd(num)};
  for (Eigen::Index k = 1; k < 3 && num > 0; ++k) {
    const auto of = static_cast<std::size_t>(k - 1);
    const auto [low, high] =
        std::ranges::minmax_element(all, {}, [&](const auto& one) { return one[of]; });
    const double middle = ((*low)[of] + (*high)[of]) / 2;
    const double span = std::max((*high)[of] - (*low)[of], 1e-12);
    for (Eigen::Index i = 0; i < num; ++i) {
      change.columns(i, k) = (all[static_cast<std::size_t>(i)][of] - middle) / span;
    }
  }
  for (Eigen::Index i = 0; i < num; ++i) {
    change.change_mm[i] = all[static_cast<std::size_t>(i)][2];
  }
  return change;
}

// Whether the places were touched along the way that the plane rises.
bool IsInOrder(const Eigen::VectorXd& plane, const HeightMap& now) {
  constexpr double kAlong = 0.9;
  const bool is_x = std::abs(plane[1]) > std::abs(plane[2]);
  double n = 0, order = 0, at = 0, both = 0, order2 = 0, at2 = 0;
  for (const auto& [place, rows] : now) {
    const auto x = static_cast<double>(is_x ? place.first : place.second);
    const auto y = static_cast<double>(rows.front()->row);
    n += 1;
    at += x;
    order += y;
    both += x * y;
    at2 += x * x;
    order2 += y * y;
  }
  const double covariance = both - at * order / n;
  const double variance = (at2 - at * at / n) * (order2 - order * order / n);
  return variance > 0 && std::abs(covariance) > kAlong * std::sqrt(variance);
}

/// Shift, and change from end to end along x and y.
struct PlaneFit {
  Eigen::VectorXd sizes_mm{};
  double left_mm = 0;     ///< The most that it leaves at a place.
  bool is_whole = false;  ///< It leaves a fifth of the changes' spread or less.
};

// None where it is no plane, or no more than the readings scatter. `noise_mm` of one
// change; kUnknown: nothing shows it. Of many places what the plane leaves shows it.
std::optional<PlaneFit> PlaneOf(const Change& change, double noise_mm) {
  constexpr Eigen::Index kFewest = 4, kMany = 9;
  constexpr double kOfSpread = 0.2, kOfFew = 0.05, kOfVariance = 0.4, kLeast_mm = 0.02;
  constexpr double kSure = 6;
  const Eigen::Index num = change.change_mm.size();
  if (num < kFewest) return std::nullopt;
  const Eigen::MatrixXd normal = change.columns.transpose() * change.columns;
  if (EigenvaluesOf(normal)[0] < 1e-6 * normal.trace()) return std::nullopt;
  const Eigen::VectorXd plane = LeastSquares(change.columns, change.change_mm);
  const Eigen::VectorXd left = change.change_mm - change.columns * plane;
  const Eigen::VectorXd about = change.change_mm.array() - change.change_mm.mean();
  const double left_mm = left.cwiseAbs().maxCoeff();
  const double spread_mm = change.change_mm.maxCoeff() - change.change_mm.minCoeff();
  const double tilt_mm = plane.tail(2).cwiseAbs().maxCoeff();
  // Many places need not lie on it to the last: it explains most of their variance.
  const double variance = left.squaredNorm() / static_cast<double>(num - 3);
  const bool explains_most =
      num >= kMany &&
      variance < kOfVariance * about.squaredNorm() / static_cast<double>(num - 1);
  // What scatters: the readings, or what the plane leaves.
  const bool is_stated = num < kMany && Known(noise_mm);
  const double sd_mm = std::max(is_stated ? noise_mm : 0.0, std::sqrt(variance));
  const bool is_seen =
      num >= kMany || Known(noise_mm)
          ? tilt_mm * std::sqrt(static_cast<double>(num)) > 2 * kSure * sd_mm
          : left_mm < kOfFew * spread_mm;
  const bool is_whole = left_mm < kOfSpread * spread_mm;
  const bool is_plane = spread_mm > kLeast_mm && is_seen && (is_whole || explains_most);
  return is_plane ? std::optional(PlaneFit{plane, left_mm, is_whole}) : std::nullopt;
}

Fact FactOf(const Change& change,
            const PlaneFit& fit,
            const std::string& before,
            const std::string& now) {
  const Eigen::VectorXd& plane = fit.sizes_mm;
  return {
      .id = "map_change",
      .axis = "z",
      .word = "tilt",
      .figures = {{"shift_um", UmFromMm(plane[0])},
                  {"tilt_x_um", UmFromMm(plane[1])},
                  {"tilt_y_um", UmFromMm(plane[2])},
                  {"left_um", UmFromMm(fit.left_mm)}},
      .sentence = fmt::format(
          "From '{}' to '{}' the heights change by {:.0f} to {:.0f} um, and {} a "
          "plane: "
          "{:+.0f} um all over, {:+.0f} um from left to right and {:+.0f} from front "
          "to "
          "back; it leaves {} um{}. Something rigid "
          "tilted between them (a screw or coupling that slips, a loose wheel, a screw "
          "under the bed); a firmware's reckoning would change the zero or the shape",
          before,
          now,
          UmFromMm(change.change_mm.minCoeff()),
          UmFromMm(change.change_mm.maxCoeff()),
          fit.is_whole ? "that is" : "most of that is",
          UmFromMm(plane[0]),
          UmFromMm(plane[1]),
          UmFromMm(plane[2]),
          TwoDigits(UmFromMm(fit.left_mm)),
          fit.is_whole ? ", so the shape is the same" : ""),
      .is_answer = true};
}

}  // namespace

void FactsOfMapChange(const Rows& rows, const Repeats& repeats, Facts* facts) {
  const auto maps = HeightMapsOf(rows, repeats);
  for (std::size_t k = 1; k < maps.size(); ++k) {
    const Change change = ChangeOf(maps[k - 1].second, maps[k].second);
    // Of the difference of two means.
    const double num = static_cast<double>(rows.size()) /
                       static_cast<double>(std::max<std::ptrdiff_t>(
                           1, change.change_mm.size() * std::ssize(maps)));
    const double noise_mm = repeats.noise.sd_mm * std::sqrt(2 / num);
    const auto plane = PlaneOf(change, noise_mm);
    if (!plane) continue;
    const bool is_single =
        change.change_mm.size() == std::ssize(rows) / std::ssize(maps) &&
        !Known(repeats.noise.sd_mm);
    Fact fact = FactOf(change, *plane, maps[k - 1].first, maps[k].first);
    if (IsInOrder(plane->sizes_mm, maps[k].second)) {
      fact.sentence +=
          ". The places were touched along that slope, so a probe or bed "
          "that warmed meanwhile does the same: touch the first place again "
          "at the end, that parts them";
    }
    if (is_single) {
      fact.sentence +=
          ". Each was measured once: what it has to do with what was "
          "changed in between nobody knows before both are repeated";
    }
    facts->all.push_back(std::move(fact));
    return;
  }
}

}  // namespace caltwin

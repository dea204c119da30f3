#include "calibration/facts/map_change.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <fmt/format.h>

#include "calibration/facts/cells.h"
#include "sim/base/dense.h"
#include "sim/base/units.h"
#include "sim/base/with_sd.h"

namespace caltwin {
namespace {

/// Heights by place, means of what was read there.
using Heights = std::map<std::pair<double, double>, Rows>;

std::vector<std::pair<std::string, Heights>> MapsOf(const Rows& rows,
                                                    const Repeats& repeats) {
  std::vector<std::pair<std::string, Heights>> maps;
  for (const Row* row : rows) {
    const bool is_height = row->kind == RowKind::kTouch && row->n[2] > 0 &&
                           Known(row->cmd_mm[0]) && Known(row->cmd_mm[1]) &&
                           !repeats.outliers.contains(row->row);
    if (!is_height) continue;
    auto own = std::ranges::find(
        maps, row->campaign, [](const auto& map) { return map.first; });
    if (own == maps.end()) own = maps.insert(own, {row->campaign, {}});
    own->second[{row->cmd_mm[0], row->cmd_mm[1]}].push_back(row);
  }
  return maps;
}

double Mean_mm(const Rows& rows) {
  double sum_mm = 0;
  for (const Row* row : rows) sum_mm += row->value_mm;
  return sum_mm / static_cast<double>(rows.size());
}

/// Changes and where: columns 1, u, v.
struct Change {
  Eigen::MatrixXd columns{};
  Eigen::VectorXd change_mm{};
};

Change ChangeOf(const Heights& before, const Heights& now) {
  std::vector<std::array<double, 3>> all;
  for (const auto& [place, rows] : now) {
    const auto then = before.find(place);
    if (then != before.end())
      all.push_back({place.first, place.second, Mean_mm(rows) - Mean_mm(then->second)});
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
bool IsInOrder(const Eigen::VectorXd& plane, const Heights& now) {
  constexpr double kAlong = 0.9;
  const bool is_x = std::abs(plane[1]) > std::abs(plane[2]);
  double n = 0, order = 0, at = 0, both = 0, order2 = 0, at2 = 0;
  for (const auto& [place, rows] : now) {
    const double x = is_x ? place.first : place.second;
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

}  // namespace

void FactsOfMapChange(const Rows& rows, const Repeats& repeats, Facts* facts) {
  constexpr Eigen::Index kFewest = 4;
  constexpr double kOfSpread = 0.2, kLeast_mm = 0.02;
  const auto maps = MapsOf(rows, repeats);
  for (std::size_t k = 1; k < maps.size(); ++k) {
    const Change change = ChangeOf(maps[k - 1].second, maps[k].second);
    if (change.change_mm.size() < kFewest) continue;
    const Eigen::MatrixXd normal = change.columns.transpose() * change.columns;
    if (EigenvaluesOf(normal)[0] < 1e-6 * normal.trace()) continue;
    const Eigen::VectorXd plane = LeastSquares(change.columns, change.change_mm);
    const double left_mm =
        (change.change_mm - change.columns * plane).cwiseAbs().maxCoeff();
    const double spread_mm = change.change_mm.maxCoeff() - change.change_mm.minCoeff();
    // Many places need not lie on it to the last: it explains most of their variance.
    constexpr Eigen::Index kMany = 9;
    constexpr double kOfVariance = 0.4;
    const auto num = change.change_mm.size();
    const Eigen::VectorXd left = change.change_mm - change.columns * plane;
    const Eigen::VectorXd about = change.change_mm.array() - change.change_mm.mean();
    const bool explains_most =
        num >= kMany &&
        left.squaredNorm() / static_cast<double>(num - 3) <
            kOfVariance * about.squaredNorm() / static_cast<double>(num - 1);
    if (spread_mm < kLeast_mm || (left_mm > kOfSpread * spread_mm && !explains_most)) {
      continue;
    }
    const bool is_single =
        change.change_mm.size() == std::ssize(rows) / std::ssize(maps) &&
        !Known(repeats.noise.sd_mm);
    facts->all.push_back(
        {.id = "map_change",
         .axis = "z",
         .word = "tilt",
         .figures = {{"shift_um", UmFromMm(plane[0])},
                     {"tilt_x_um", UmFromMm(plane[1])},
                     {"tilt_y_um", UmFromMm(plane[2])},
                     {"left_um", UmFromMm(left_mm)}},
         .sentence = fmt::format(
             "From '{}' to '{}' the heights change by {:.0f} to {:.0f} um, and that is "
             "a plane: {:+.0f} um all over, {:+.0f} um from left to right and {:+.0f} "
             "from front to back; it leaves {} um, so the shape is the same. Something "
             "rigid tilted between them (a screw or coupling that slips, a loose "
             "wheel, "
             "a screw under the bed){}; a firmware's reckoning would change the zero "
             "or "
             "the shape{}",
             maps[k - 1].first,
             maps[k].first,
             UmFromMm(change.change_mm.minCoeff()),
             UmFromMm(change.change_mm.maxCoeff()),
             UmFromMm(plane[0]),
             UmFromMm(plane[1]),
             UmFromMm(plane[2]),
             TwoDigits(UmFromMm(left_mm)),
             IsInOrder(plane, maps[k].second)
                 ? ", or the probe or the bed warmed while the places were touched in "
                   "this order: touch the first place again at the end, that parts them"
                 : "",
             is_single ? ". Each was measured once: what it has to do with what was "
                         "changed in between nobody knows before both are repeated"
                       : ""),
         .is_answer = true});
    return;
  }
}

}  // namespace caltwin

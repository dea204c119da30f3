#include "calibration/facts/tower_heights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "calibration/facts/cells.h"
#include "sim/base/units.h"
#include "sim/base/with_sd.h"

namespace caltwin {
namespace {

constexpr std::array<const char*, 3> kTowers = {"x", "y", "z"};

/// Heights of the centre and towers, and of the places across from x, y, z [mm].
struct Points {
  std::array<double, 4> calibrated_mm{};
  std::array<double, 3> across_mm{};
};

std::optional<Points> PointsOf(const Rows& rows) {
  std::map<std::string, double> heights_mm;
  for (const Row* row : rows) {
    if (!row->feature.starts_with("delta.")) return std::nullopt;
    heights_mm[row->feature.substr(6)] = row->value_mm;
  }
  constexpr std::size_t kAll = 7;
  if (heights_mm.size() != kAll) return std::nullopt;
  Points points;
  for (std::size_t k = 0; k < 3; ++k) {
    points.calibrated_mm[k] = heights_mm[kTowers[k]];
    points.across_mm[k] = heights_mm[std::string("o") + kTowers[k]];
  }
  points.calibrated_mm[3] = heights_mm["c"];
  return points;
}

double Largest(const auto& values) {
  double largest = 0;
  for (const double value : values) largest = std::max(largest, std::abs(value));
  return largest;
}

std::string OneTower(const std::array<double, 3>& apart_mm, std::string* tower) {
  const auto odd = static_cast<std::size_t>(
      std::ranges::max_element(apart_mm, {}, [](double mm) { return std::abs(mm); }) -
      apart_mm.begin());
  const double one = apart_mm[(odd + 1) % 3], other = apart_mm[(odd + 2) % 3];
  // Two of opposite sign and the third at rest: an angle.
  const std::size_t still = static_cast<std::size_t>(
      std::ranges::min_element(apart_mm, {}, [](double mm) { return std::abs(mm); }) -
      apart_mm.begin());
  constexpr double kStill = 0.2;
  if (std::abs(apart_mm[still]) < kStill * std::abs(apart_mm[odd])) {
    *tower = kTowers[still];
    return fmt::format(
        "the places across from the other two are apart and that across "
        "from tower {0} is not: the angle of tower {0}",
        kTowers[still]);
  }
  *tower = kTowers[odd];
  return fmt::format(
      "that across from tower {0} stands {1} um apart from the other two, which agree "
      "to {2} um: tower {0} stands further out or in than written, or its pair of rods "
      "is of another length; seven heights do not part the two, and do not tell how "
      "far "
      "without rods and radius. Measure the three towers' distances and the six rods",
      kTowers[odd],
      TwoDigits(UmFromMm(std::abs(apart_mm[odd] - (one + other) / 2))),
      TwoDigits(UmFromMm(std::abs(one - other))));
}

}  // namespace

void FactsOfTowerHeights(const Rows& rows, Facts* facts) {
  constexpr double kLeast_mm = 0.02, kCalibrated = 0.35, kShared = 2;
  const auto points = PointsOf(rows);
  if (!points) return;
  const double calibrated_mm = Largest(points->calibrated_mm);
  const double across_mm = Largest(points->across_mm);
  if (across_mm < kLeast_mm || calibrated_mm > kCalibrated * across_mm) return;
  const double mean_mm =
      (points->across_mm[0] + points->across_mm[1] + points->across_mm[2]) / 3;
  std::array<double, 3> apart_mm = points->across_mm;
  for (double& each_mm : apart_mm) each_mm -= mean_mm;
  const double spread_mm = Largest(apart_mm);
  std::string tower;
  std::string says;
  if (std::abs(mean_mm) > kShared * spread_mm) {
    says = fmt::format(
        "they are all {:+.0f} um off, alike to {} um: rods and radius do not belong "
        "together, or steps/mm of all towers are off. Measure the rods from joint to "
        "joint, enter them, and calibrate again",
        UmFromMm(mean_mm),
        TwoDigits(UmFromMm(spread_mm)));
  } else if (spread_mm > kShared * std::abs(mean_mm)) {
    says = fmt::format(
        "on average they are {:+.0f} um off, so neither rods of another length nor "
        "steps/mm, which would move all three alike; {}",
        UmFromMm(mean_mm),
        OneTower(apart_mm, &tower));
  } else {
    says = fmt::format(
        "they are {:+.0f} um off on average, which rods or steps/mm "
        "would do, and up to {} um about that, which one tower does",
        UmFromMm(mean_mm),
        TwoDigits(UmFromMm(spread_mm)));
  }
  facts->all.push_back({.id = "tower_heights",
                        .axis = tower,
                        .word = tower.empty() ? "all" : "tower",
                        .figures = {{"mean_um", UmFromMm(mean_mm)},
                                    {"apart_um", UmFromMm(spread_mm)},
                                    {"calibrated_um", UmFromMm(calibrated_mm)}},
                        .sentence = fmt::format("Centre and towers are level to {} um; "
                                                "the places across from the towers are "
                                                "not: {}",
                                                TwoDigits(UmFromMm(calibrated_mm)),
                                                says),
                        .is_answer = true});
}

}  // namespace caltwin

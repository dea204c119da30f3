#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "calibration/facts/repeats.h"
#include "sim/measure/row.h"

namespace caltwin {

/// @name Terms of a surface: a plane, a plane and a twist, and all of second order
inline constexpr Eigen::Index kPlaneTerms = 3;
inline constexpr Eigen::Index kTwistTerms = 4;
inline constexpr Eigen::Index kAllTerms = 6;

/// One touched place: the mean of its readings.
struct Spot {
  double x_mm = 0, y_mm = 0, height_mm = 0;
  double num = 0;
  std::vector<std::int64_t> rows{};
};

/// Spots of one bed as it stood, scaled to -1 .. 1.
class Sheet {
 public:
  explicit Sheet(std::vector<Spot> spots) : spots_(std::move(spots)) {
    double low_x = HUGE_VAL, high_x = -HUGE_VAL, low_y = HUGE_VAL, high_y = -HUGE_VAL;
    for (const Spot& spot : spots_) {
      low_x = std::min(low_x, spot.x_mm);
      high_x = std::max(high_x, spot.x_mm);
      low_y = std::min(low_y, spot.y_mm);
      high_y = std::max(high_y, spot.y_mm);
    }
    mid_ = {(low_x + high_x) / 2, (low_y + high_y) / 2};
    half_mm_ = {(high_x - low_x) / 2, (high_y - low_y) / 2};
  }

  Eigen::Index size() const { return static_cast<Eigen::Index>(spots_.size()); }
  const std::vector<Spot>& spots() const { return spots_; }
  const Eigen::Vector2d& half_mm() const { return half_mm_; }
  bool has_area() const { return half_mm_.minCoeff() > 1; }

  /// Columns 1 u v uv u^2 v^2, as many as asked for.
  Eigen::MatrixXd Columns(Eigen::Index num) const {
    Eigen::MatrixXd columns(size(), num);
    for (Eigen::Index i = 0; i < size(); ++i) {
      const Spot& spot = spots_[static_cast<std::size_t>(i)];
      const double u = (spot.x_mm - mid_[0]) / half_mm_[0];
      const double v = (spot.y_mm - mid_[1]) / half_mm_[1];
      const double all[kAllTerms] = {1, u, v, u * v, u * u, v * v};
      for (Eigen::Index k = 0; k < num; ++k) columns(i, k) = all[k];
    }
    return columns;
  }

  Eigen::VectorXd Heights_mm() const {
    Eigen::VectorXd heights_mm(size());
    for (Eigen::Index i = 0; i < size(); ++i) {
      heights_mm[i] = spots_[static_cast<std::size_t>(i)].height_mm;
    }
    return heights_mm;
  }

  /// Readings of a spot, in the mean.
  double MeanReadings() const {
    double num = 0;
    for (const Spot& spot : spots_) num += spot.num;
    return num / static_cast<double>(size());
  }

  Sheet Without(const std::vector<bool>& is_out) const {
    std::vector<Spot> kept;
    for (std::size_t i = 0; i < spots_.size(); ++i) {
      if (!is_out[i]) kept.push_back(spots_[i]);
    }
    return Sheet(std::move(kept));
  }

 private:
  std::vector<Spot> spots_;
  Eigen::Vector2d mid_ = Eigen::Vector2d::Zero(), half_mm_ = Eigen::Vector2d::Zero();
};

/// Least squares of spots: sizes, their standard deviations for a noise of one.
struct SheetFit {
  Eigen::VectorXd sizes_mm{}, unit_sds{}, left_mm{};
  double dof = 0;
  bool is_determined = false;
  double squares_mm2() const { return left_mm.squaredNorm(); }
};

/// Of the first so many terms.
SheetFit Fit(const Sheet& sheet, Eigen::Index terms);

/// Spots that lie far from the surface of all others, by least trimmed squares: of many
/// surfaces through as many spots as they have sizes, the one whose better half of
/// distances is smallest. Bad touches cannot hide each other.
std::vector<bool> FarSpots(const Sheet& sheet, double noise_mm);

/// Touched heights by campaign, setup, feature, homing and commanded height, without
/// the rows that are `out`.
std::map<std::string, std::vector<Spot>> SheetsOf(const std::vector<const Row*>& rows,
                                                  const std::set<std::int64_t>& out);

/// Standard deviation of a spot; kUnknown where nothing shows it.
struct SpotNoise {
  double sd_mm = kUnknown;
  double dof = 0;
};

/// Of repeats, else of what a fit leaves.
SpotNoise NoiseOf(const Sheet& sheet, const SheetFit& fit, const ReadingNoise& noise);

}  // namespace caltwin

#include "sim/measure/import/growth_fit.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Dense>

#include "sim/base/median.h"
#include "sim/base/units.h"
#include "sim/measure/climate.h"

namespace caltwin {
namespace {

constexpr double kGrossly = 20;  // Median residuals.
constexpr std::size_t kFewest = 10;
constexpr double kMostBlocks = 12;

struct Lags {
  double frame_s = 0;
  double bed_s = 0;
};

struct Fitted {
  Lags lags{};
  Eigen::Vector3d terms = Eigen::Vector3d::Zero();
  double square_mm2 = INFINITY;
};

class Heights {
 public:
  explicit Heights(const RowTable& table) {
    TemperatureLog frame, bed;
    for (const Row& row : table.rows) {
      if (!Known(row.temp_frame_c) || !Known(row.t_s)) continue;
      times_s_.push_back(row.t_s);
      values_mm_.push_back(row.value_mm);
      frame.Add(row.t_s, row.temp_frame_c);
      bed.Add(row.t_s, Known(row.temp_bed_c) ? row.temp_bed_c : 0);
    }
    used_.assign(times_s_.size(), true);
    for (const double lag_s : kLags_s) {
      frame_k_.push_back(Felt(frame, lag_s));
      bed_k_.push_back(Felt(bed, lag_s));
    }
    if (times_s_.size() >= kFewest) LeaveGrossOut();
  }

  bool enough() const { return times_s_.size() >= kFewest; }

  /// The best of all lags, or without lag; `left_out` of the readings not fitted.
  Fitted Best(bool is_lagged, const std::vector<bool>& left_out) const {
    Fitted best;
    const std::size_t most = is_lagged ? kLags_s.size() : 1;
    for (std::size_t f = 0; f < most; ++f) {
      for (std::size_t b = 0; b < most; ++b) {
        const Fitted one = Fit(f, b, left_out);
        if (one.square_mm2 < best.square_mm2) best = one;
      }
    }
    return best;
  }

  GrowthFit Growth(bool is_lagged) const {
    if (!enough()) return {};
    const std::vector<bool> none(times_s_.size(), false);
    const Fitted all = Best(is_lagged, none);
    const double variance_mm2 = Variance_mm2();
    return {.frame_mm_per_k = all.terms[0],
            .bed_mm_per_k = all.terms[1],
            .frame_lag_s = all.lags.frame_s,
            .bed_lag_s = all.lags.bed_s,
            .rms_mm = std::sqrt(all.square_mm2 / Count(none)),
            .explained =
                variance_mm2 > 0 ? 1 - all.square_mm2 / Count(none) / variance_mm2 : 0,
            .held_out_rms_mm = HeldOut_mm(is_lagged)};
  }

 private:
  // From none to two hours, each a third more than the last.
  static inline const std::vector<double> kLags_s = [] {
    std::vector<double> lags_s = {0};
    for (double lag_s = 30; lag_s < 7300; lag_s *= 4.0 / 3) lags_s.push_back(lag_s);
    return lags_s;
  }();

  std::vector<double> Felt(const TemperatureLog& log, double lag_s) const {
    std::vector<double> felt_k;
    for (const double t_s : times_s_) felt_k.push_back(log.Lagged_k(t_s, lag_s));
    return felt_k;
  }

  Eigen::Vector3d TermsOf(std::size_t i, std::size_t frame, std::size_t bed) const {
    return {frame_k_[frame][i], bed_k_[bed][i], 1};
  }

  Fitted Fit(std::size_t frame,
             std::size_t bed,
             const std::vector<bool>& left_out) const {
    Eigen::Matrix3d normal = 1e-9 * Eigen::Matrix3d::Identity();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    double square = 0;
    for (std::size_t i = 0; i < times_s_.size(); ++i) {
      if (!used_[i] || left_out[i]) continue;
      const Eigen::Vector3d terms = TermsOf(i, frame, bed);
      normal += terms * terms.transpose();
      right += terms * values_mm_[i];
      square += values_mm_[i] * values_mm_[i];
    }
    const Eigen::Vector3d terms = normal.ldlt().solve(right);
    return {.lags = {kLags_s[frame], kLags_s[bed]},
            .terms = terms,
            .square_mm2 = std::max(square - right.dot(terms), 0.0)};
  }

  std::size_t IndexOf(double lag_s) const {
    return static_cast<std::size_t>(std::ranges::find(kLags_s, lag_s) -
                                    kLags_s.begin());
  }

  double Residual_mm(const Fitted& fitted, std::size_t i) const {
    return values_mm_[i] -
           fitted.terms.dot(
               TermsOf(i, IndexOf(fitted.lags.frame_s), IndexOf(fitted.lags.bed_s)));
  }

  void LeaveGrossOut() {
    const Fitted fitted = Best(false, std::vector<bool>(times_s_.size(), false));
    std::vector<double> sizes_mm;
    for (std::size_t i = 0; i < times_s_.size(); ++i) {
      sizes_mm.push_back(std::abs(Residual_mm(fitted, i)));
    }
    const double usual_mm = Median(sizes_mm);
    for (std::size_t i = 0; i < times_s_.size(); ++i) {
      used_[i] = sizes_mm[i] <= kGrossly * usual_mm;
    }
  }

  double Count(const std::vector<bool>& left_out) const {
    double count = 0;
    for (std::size_t i = 0; i < used_.size(); ++i) {
      if (used_[i] && !left_out[i]) count += 1;
    }
    return count;
  }

  double Variance_mm2() const {
    double sum_mm = 0, square_mm2 = 0, count = 0;
    for (std::size_t i = 0; i < used_.size(); ++i) {
      if (!used_[i]) continue;
      sum_mm += values_mm_[i];
      square_mm2 += values_mm_[i] * values_mm_[i];
      count += 1;
    }
    return square_mm2 / count - std::pow(sum_mm / count, 2);
  }

  // Each block foretold by all the others.
  double HeldOut_mm(bool is_lagged) const {
    const double first_s = *std::ranges::min_element(times_s_);
    const double last_s = *std::ranges::max_element(times_s_);
    const double block_s = std::max(SFromH(1.0), (last_s - first_s) / kMostBlocks);
    double square_mm2 = 0, count = 0;
    const int num_blocks = 1 + static_cast<int>((last_s - first_s) / block_s);
    for (int b = 0; b < num_blocks; ++b) {
      const double from_s = first_s + b * block_s;
      std::vector<bool> block(times_s_.size());
      for (std::size_t i = 0; i < times_s_.size(); ++i) {
        block[i] = times_s_[i] >= from_s && times_s_[i] < from_s + block_s;
      }
      if (Count(block) < static_cast<double>(kFewest)) return kUnknown;
      const Fitted fitted = Best(is_lagged, block);
      for (std::size_t i = 0; i < times_s_.size(); ++i) {
        if (!block[i] || !used_[i]) continue;
        square_mm2 += std::pow(Residual_mm(fitted, i), 2);
        count += 1;
      }
    }
    return std::sqrt(square_mm2 / count);
  }

  std::vector<double> times_s_{}, values_mm_{};
  std::vector<std::vector<double>> frame_k_{}, bed_k_{};  // By lag.
  std::vector<bool> used_{};
};

}  // namespace

GrowthFit PlainGrowth(const RowTable& table) {
  return Heights(table).Growth(/*is_lagged=*/false);
}

GrowthFit LaggedGrowth(const RowTable& table) {
  return Heights(table).Growth(/*is_lagged=*/true);
}

}  // namespace caltwin

#include "sim/effects/forms.h"

#include <algorithm>

#include "sim/effects/drive.h"

namespace caltwin {

Forms OfOne(const std::vector<double>& values) {
  Forms forms;
  forms.reserve(values.size());
  for (const double value : values) forms.push_back({value});
  return forms;
}

std::vector<double> Geometric(double first, double last, int count) {
  std::vector<double> values;
  for (int i = 0; i < count; ++i) {
    values.push_back(first * std::pow(last / first, i / (count - 1.0)));
  }
  return values;
}

double Span_mm(const Extent& extent, Axis axis) {
  return extent.q_max_mm[Index(axis)] - extent.q_min_mm[Index(axis)];
}

double DriveSpan_mm(const Extent& extent, std::string_view name) {
  const Drive drive = DriveNamed(name).value();
  return drive.is_motor
             ? extent.motor_max_mm[drive.index] - extent.motor_min_mm[drive.index]
             : extent.q_max_mm[drive.index] - extent.q_min_mm[drive.index];
}

std::vector<double> Periods_mm(double drawn_mm, double span_mm) {
  constexpr double kReach = 0.03;
  constexpr int kMostEachSide = 12;
  const double num_periods = span_mm / drawn_mm;
  if (!(num_periods >= 0.25)) return {};
  // A period longer by 1 / (2 N) is a quarter of a turn late, N / 2 periods off the
  // middle.
  const double step = std::min(kReach, 1 / (2 * num_periods));
  const int each_side = std::min(kMostEachSide, static_cast<int>(kReach / step));
  std::vector<double> periods_mm;
  for (int i = -each_side; i <= each_side; ++i) {
    periods_mm.push_back(drawn_mm * (1 + i * step));
  }
  return periods_mm;
}

std::vector<double> Lags_s(const Extent& extent) {
  constexpr double kShortest_s = 50;
  constexpr int kMost = 8;  // Up to 6400 s.
  const double longest_s = 3 * (extent.t_max_s - extent.t_min_s);
  std::vector<double> lags_s = {0};
  double lag_s = kShortest_s;
  for (int i = 0; i < kMost && lag_s <= longest_s; ++i) {
    lags_s.push_back(lag_s);
    lag_s *= 2;
  }
  return lags_s;
}

std::vector<double> TimeConstants_s(const Extent& extent) {
  const double duration_s = extent.t_max_s - extent.t_min_s;
  if (!(duration_s > 0)) return {};
  constexpr int kCount = 7;
  return Geometric(duration_s / 20, 3 * duration_s, kCount);
}

std::vector<double> JumpTimes_s(const Extent& extent) {
  constexpr std::size_t kMost = 200;
  const std::vector<double>& times_s = extent.times_s;
  if (times_s.size() < 2) return {};
  const std::size_t num_gaps = times_s.size() - 1;
  const std::size_t count = std::min(num_gaps, kMost);
  std::vector<double> jumps_s;
  for (std::size_t i = 0; i < count; ++i) {
    // The middle one of the gaps that this choice stands for.
    const std::size_t gap = (2 * i + 1) * num_gaps / (2 * count);
    jumps_s.push_back((times_s[gap] + times_s[gap + 1]) / 2);
  }
  return jumps_s;
}

}  // namespace caltwin

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <type_traits>
#include <vector>

#include "sim/measure/row.h"

namespace caltwin {

/// Where temperatures are logged.
enum class Sensor { kScrew, kFrame, kBed, kChamber, kAmbient, kNozzle };
inline constexpr std::size_t kNumSensors = 6;

/// One sensor's readings over a session: straight lines between them, constant before
/// the first and after the last.
class TemperatureLog {
 public:
  /// Readings in the order of time; one at the same time as the last replaces it.
  void Add(double t_s, double temp_c);

  bool empty() const { return times_s_.empty(); }
  const std::vector<double>& times_s() const { return times_s_; }
  /// T0: the session's first reading [C]; 0 where there is none.
  double first_c() const { return temps_k_.empty() ? 0 : first_c_; }
  /// Warmest less coolest reading [K].
  double swing_k() const { return high_k_ - low_k_; }
  /// T - T0 at that time [K].
  double At_k(double t_s) const;

  /// T - T0 as a part feels it that follows with a first-order lag [K]:
  ///
  ///   lag dy/dt = (T - T0) - y,  y(first reading) = 0,
  ///
  /// exact for the straight lines. `lag_s` 0 or less gives T - T0.
  template <typename T>
  T Lagged_k(double t_s, const T& lag_s) const;

 private:
  double first_c_ = 0;
  double low_k_ = 0, high_k_ = 0;
  std::vector<double> times_s_{};
  std::vector<double> temps_k_{};
  /// States at the readings, by lag: a fit asks for the same few lags at every row.
  mutable std::map<double, std::vector<double>> states_k_{};
  const std::vector<double>& StatesFor(double lag_s) const;
};

/// What a thermometer must move before its readings are a temperature that changes.
inline constexpr double kLeastSwing_k = 0.2;

/// All temperatures of a session. Not to be shared between threads.
struct Climate {
  std::array<TemperatureLog, kNumSensors> logs{};

  const TemperatureLog& operator[](Sensor sensor) const {
    return logs[static_cast<std::size_t>(sensor)];
  }
};

/// The temperature a row says of a sensor; kUnknown where it does not.
double TemperatureOf(const Row& row, Sensor sensor);

/// One straight piece from k0 at time 0 to k1 at time `length_s`, felt with a lag by a
/// part that was at y0: its state at the end.
template <typename T>
T LagStep_k(const T& y0_k, double k0, double k1, double length_s, const T& lag_s) {
  using std::exp;
  if (length_s <= 0) return y0_k;
  const double slope = (k1 - k0) / length_s;
  // y = k(t) - slope lag + C exp(-t / lag)
  const T c = y0_k - k0 + slope * lag_s;
  return k1 - slope * lag_s + c * exp(-length_s / lag_s);
}

template <typename T>
T TemperatureLog::Lagged_k(double t_s, const T& lag_s) const {
  if (times_s_.empty()) return T(0);
  if (!(lag_s > 1e-9)) return T(At_k(t_s));
  std::size_t i = 0;
  T y_k(0);
  if constexpr (std::is_same_v<T, double>) {
    const std::vector<double>& states_k = StatesFor(lag_s);
    const auto after = std::upper_bound(times_s_.begin(), times_s_.end(), t_s);
    if (after != times_s_.begin()) {
      i = static_cast<std::size_t>(after - times_s_.begin()) - 1;
    }
    y_k = states_k[i];
  } else {
    for (; i + 1 < times_s_.size() && times_s_[i + 1] <= t_s; ++i) {
      y_k = LagStep_k(
          y_k, temps_k_[i], temps_k_[i + 1], times_s_[i + 1] - times_s_[i], lag_s);
    }
  }
  return LagStep_k(y_k, temps_k_[i], At_k(t_s), t_s - times_s_[i], lag_s);
}

}  // namespace caltwin

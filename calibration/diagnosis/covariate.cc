#include "calibration/diagnosis/covariate.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "sim/base/units.h"

namespace caltwin {
namespace {

// The sensor whose readings move most; none if no row has a temperature.
std::optional<Sensor> LiveliestSensor(const Observed& o) {
  std::optional<Sensor> liveliest;
  double most_k = 0.2;
  for (std::size_t s = 0; s < kNumSensors; ++s) {
    const auto sensor = static_cast<Sensor>(s);
    const TemperatureLog& log = o.climate()[sensor];
    double low = 0, high = 0;
    for (const double t_s : log.times_s()) {
      low = std::min(low, log.At_k(t_s));
      high = std::max(high, log.At_k(t_s));
    }
    if (high - low > most_k) {
      most_k = high - low;
      liveliest = sensor;
    }
  }
  return liveliest;
}

double ValueOf(const Observed& o,
               std::string_view word,
               const std::optional<Sensor>& sensor,
               Eigen::Index i) {
  const At& at = o.at(i);
  if (const auto axis = AxisNamed(word)) return at.q_mm[Index(*axis)];
  if (word.starts_with("dir_")) return at.dir[Index(*AxisNamed(word.substr(4)))];
  if (word == "t") return at.t_s;
  if (word == "temp") return sensor ? o.climate()[*sensor].At_k(at.t_s) : kUnknown;
  if (word == "feed") return at.feed_mm_s;
  if (word == "load") return at.load_n;
  if (word == "theta") {
    if (std::hypot(at.n.x(), at.n.y()) < 0.5) return kUnknown;
    return std::atan2(at.n.y(), at.n.x());
  }
  if (word == "since_rev") {
    // Of the axis the value is measured along.
    int most = 0;
    for (int k = 1; k < 3; ++k) {
      if (std::abs(at.n[k]) > std::abs(at.n[most])) most = k;
    }
    return at.since_rev_mm[most];
  }
  return kUnknown;
}

}  // namespace

double Covariate::Scaled(double value) const {
  return max > min ? std::clamp(2 * (value - min) / (max - min) - 1, -1.0, 1.0) : 0;
}

std::optional<Covariate> CovariateOf(const Observed& observed, std::string_view word) {
  constexpr std::size_t kMostCounted = 64;
  Covariate covariate{.word = std::string(word),
                      .values = Eigen::VectorXd(observed.num_rows())};
  const auto sensor =
      word == "temp" ? LiveliestSensor(observed) : std::optional<Sensor>{};
  std::set<double> distinct;
  for (Eigen::Index i = 0; i < observed.num_rows(); ++i) {
    const double value = ValueOf(observed, word, sensor, i);
    if (!Known(value)) return std::nullopt;
    covariate.values[i] = value;
    if (distinct.size() < kMostCounted) distinct.insert(std::round(value * 1e3) / 1e3);
  }
  covariate.min = covariate.values.minCoeff();
  covariate.max = covariate.values.maxCoeff();
  covariate.num_distinct = static_cast<int>(distinct.size());
  covariate.is_periodic = word == "theta";
  if (covariate.num_distinct < 2) return std::nullopt;
  return covariate;
}

Eigen::VectorXd ChannelOf(const Observed& observed, std::string_view channel) {
  Eigen::VectorXd shows(observed.num_rows());
  for (Eigen::Index i = 0; i < observed.num_rows(); ++i) {
    const bool is_touch = observed.at(i).kind == RowKind::kTouch;
    if (const auto axis = AxisNamed(channel)) {
      shows[i] = observed.MotionSign(i) * observed.at(i).n[Index(*axis)];
    } else if (channel == "probe") {
      shows[i] = is_touch ? -1 : 0;
    } else {
      shows[i] = is_touch ? observed.at(i).n.z() : 0;
    }
  }
  return shows;
}

}  // namespace caltwin

#include "sim/measure/climate.h"

#include <algorithm>

namespace caltwin {

void TemperatureLog::Add(double t_s, double temp_c) {
  if (times_s_.empty()) first_c_ = temp_c;
  if (!times_s_.empty() && t_s <= times_s_.back()) {
    temps_k_.back() = temp_c - first_c_;
  } else {
    times_s_.push_back(t_s);
    temps_k_.push_back(temp_c - first_c_);
  }
  low_k_ = std::min(low_k_, temps_k_.back());
  high_k_ = std::max(high_k_, temps_k_.back());
  states_k_.clear();
}

double TemperatureLog::At_k(double t_s) const {
  if (times_s_.empty()) return 0;
  const auto after = std::upper_bound(times_s_.begin(), times_s_.end(), t_s);
  if (after == times_s_.begin()) return temps_k_.front();
  if (after == times_s_.end()) return temps_k_.back();
  const auto i = static_cast<std::size_t>(after - times_s_.begin());
  const double part = (t_s - times_s_[i - 1]) / (times_s_[i] - times_s_[i - 1]);
  return temps_k_[i - 1] + part * (temps_k_[i] - temps_k_[i - 1]);
}

const std::vector<double>& TemperatureLog::StatesFor(double lag_s) const {
  constexpr std::size_t kMostLags = 256;
  if (states_k_.size() > kMostLags) states_k_.clear();
  std::vector<double>& states_k = states_k_[lag_s];
  if (states_k.size() == times_s_.size()) return states_k;
  states_k.assign(times_s_.size(), 0);
  for (std::size_t i = 1; i < times_s_.size(); ++i) {
    states_k[i] = LagStep_k(states_k[i - 1],
                            temps_k_[i - 1],
                            temps_k_[i],
                            times_s_[i] - times_s_[i - 1],
                            lag_s);
  }
  return states_k;
}

double TemperatureOf(const Row& row, Sensor sensor) {
  switch (sensor) {
    case Sensor::kScrew:
      return row.temp_screw_c;
    case Sensor::kFrame:
      return row.temp_frame_c;
    case Sensor::kBed:
      return row.temp_bed_c;
    case Sensor::kChamber:
      return row.temp_chamber_c;
    case Sensor::kNozzle:
      return row.temp_nozzle_c;
    case Sensor::kAmbient:
      break;
  }
  return row.temp_ambient_c;
}

}  // namespace caltwin

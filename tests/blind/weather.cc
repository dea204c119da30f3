#include "tests/blind/weather.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace blind {

double History::At(double t_s) const {
  const double place =
      std::clamp(t_s / step_s, 0.0, static_cast<double>(values.size()) - 1.000001);
  const auto i = static_cast<std::size_t>(place);
  const double part = place - static_cast<double>(i);
  return (1 - part) * values[i] + part * values[i + 1];
}

History Lag(const History& input, double tau_s) {
  History output = input;
  const double keep = std::exp(-input.step_s / tau_s);
  double y = input.First();
  for (std::size_t i = 1; i < input.values.size(); ++i) {
    const double u = 0.5 * (input.values[i - 1] + input.values[i]);
    y = u + (y - u) * keep;
    output.values[i] = y;
  }
  return output;
}

Weather::Weather(const WeatherPlan& plan, Random random)
    : duration_s_(plan.duration_s) {
  for (History& history : histories_) history.values.clear();
  const double room_c = random.Uniform(18, 24);
  const double swing_k = random.Uniform(0.2, 1.0);
  const double period_s = random.Uniform(4000, 12000);
  const double start_rad = random.Uniform(0, 6.28);
  // Heat reaches the screw first, then frame and bed, each by its own way.
  const double screw_rise_k = plan.from_cold ? random.Uniform(8, 16) : 0.8;
  const double frame_rise_k = plan.from_cold ? random.Uniform(3, 7) : 0.3;
  const double bed_rise_k = plan.from_cold ? random.Uniform(4, 9) : 0.3;
  const double screw_tau_s = random.Uniform(900, 1600);
  const double frame_tau_s = random.Uniform(2000, 3600);
  const double bed_tau_s = random.Uniform(500, 1100);
  const double bed_start_s = plan.heating_until_s * random.Uniform(0.1, 0.35);
  double screw_k = 0;
  double frame_k = 0;
  double bed_k = 0;
  double chamber_k = 0;
  const double step_s = histories_[0].step_s;
  const int steps = static_cast<int>(plan.duration_s / step_s) + 3;
  for (int step = 0; step < steps; ++step) {
    const double t_s = step * step_s;
    const bool heated = t_s < plan.heating_until_s;
    const double ambient_c =
        room_c +
        swing_k * (std::sin(2 * std::numbers::pi * t_s / period_s + start_rad) -
                   std::sin(start_rad));
    const std::array<double, kThermometers> now_c = {ambient_c + screw_k,
                                                     ambient_c + frame_k,
                                                     ambient_c + bed_k,
                                                     ambient_c + chamber_k,
                                                     ambient_c};
    for (std::size_t i = 0; i < now_c.size(); ++i) {
      histories_[i].values.push_back(now_c[i]);
    }
    const bool bed_heated = heated && t_s >= bed_start_s;
    screw_k += step_s / screw_tau_s * ((heated ? screw_rise_k : 0) - screw_k);
    frame_k += step_s / frame_tau_s * ((heated ? frame_rise_k : 0) - frame_k);
    bed_k += step_s / bed_tau_s * ((bed_heated ? bed_rise_k : 0) - bed_k);
    chamber_k += step_s / 1500 * (0.3 * (screw_k + bed_k) - chamber_k);
  }
}

History Weather::Lagged(Thermometer which, double tau_s) const {
  History lagged = Lag(history(which), tau_s);
  const double first_c = lagged.First();
  for (double& value : lagged.values) value -= first_c;
  return lagged;
}

}  // namespace blind

#pragma once

#include <array>
#include <vector>

#include "tests/blind/gantry.h"
#include "tests/blind/random.h"

namespace blind {

/// A quantity over time on a regular grid, read by linear interpolation.
struct History {
  double step_s = 5;
  std::vector<double> values{};

  double At(double t_s) const;
  double First() const { return values.front(); }
};

/// What happens to the machine's temperatures.
struct WeatherPlan {
  double duration_s = 3600;
  /// From cold to warm and back, as in a drift campaign; else it stays nearly even.
  bool from_cold = false;
  double heating_until_s = 0;  ///< The spindle is switched off then.
};

/// Temperatures of screw, frame, bed, chamber and room over a session: each a node of a
/// heat network driven by spindle and room, integrated forward.
class Weather {
 public:
  Weather(const WeatherPlan& plan, Random random);

  const History& history(Thermometer which) const {
    return histories_[static_cast<std::size_t>(which)];
  }
  double At(Thermometer which, double t_s) const { return history(which).At(t_s); }
  /// A temperature after a first-order lag of `tau_s`, minus its first value [K].
  History Lagged(Thermometer which, double tau_s) const;
  double duration_s() const { return duration_s_; }

 private:
  std::array<History, kThermometers> histories_{};
  double duration_s_ = 0;
};

/// First-order lag by integration on the grid of `input`: dy/dt = (u - y) / tau.
History Lag(const History& input, double tau_s);

}  // namespace blind

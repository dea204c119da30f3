#pragma once

#include <array>
#include <map>
#include <vector>

#include "sim/measure/climate.h"
#include "sim/measure/row.h"

namespace caltwin {

/// When the machine's own heat sources run, all times from the start of a campaign [s].
struct HeatPlan {
  double spindle_on_s = 0, spindle_off_s = 0;
  double bed_on_s = 0, bed_off_s = 0;
  double screw_rise_k = 10;  ///< Reached after long running.
  double frame_rise_k = 4;
  double bed_rise_k = 6;
};

/// Temperatures of a session: the room's slow swing of 0.15 K about 20.0 C (period 5
/// h), and of every part what its heat source adds, by a first-order lag. Screw 20 min,
/// frame 50 min, bed 15 min, chamber 30 min: a warm spindle heats screws first, then
/// the frame; the bed has its own heater, so that the two can be told apart.
class Weather {
 public:
  void Heat(double now_s, const HeatPlan& plan);
  /// A heater holds it at that from then on, reached by the next reading.
  void Hold(Sensor sensor, double from_s, double temp_c);
  double At_c(Sensor sensor, double t_s) const;
  /// Writes all temperatures into the row, as thermometers of 0.01 K show them; that of
  /// a nozzle where one is held.
  void Write(double t_s, Row* row) const;

 private:
  struct Source {
    double on_s = 0, off_s = 0;
    double rise_k = 0;
    double lag_s = 1;
  };
  std::array<std::vector<Source>, kNumSensors> sources_{};
  std::array<std::map<double, double>, kNumSensors> held_c_{};  ///< By time from.
};

}  // namespace caltwin

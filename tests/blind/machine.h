#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tests/blind/gantry.h"
#include "tests/blind/plan.h"
#include "tests/blind/random.h"
#include "tests/blind/weather.h"

namespace blind {

/// Noise of one instrument, as it truly is.
struct Noise {
  double sigma_mm = 1e-3;
  double resolution_mm = 0;
};

/// Where an artefact truly stands.
struct Standing {
  Vector3 offset_mm{};
  double turn_rad = 0;
};

/// Everything that is true of a machine in a session.
struct Truth {
  Vector3 scale{};         ///< Moved / commanded - 1, by axis.
  Vector3 gap_mm{};        ///< Backlash.
  Vector3 pretravel_mm{};  ///< From contact to trigger, pushing along each axis.
  double bed_slope_x = 0, bed_slope_y = 0;  ///< Height per length.
  double tip_radius_mm = 1;
  std::map<std::string, Standing> standing{};  ///< By setup.
  std::vector<Defect> defects{};
};

/// A row as it is measured.
struct Reading {
  const Stop* stop = nullptr;
  Instant instant{};  ///< At the reading; for a touch that at the trigger.
  Vector3 dir{};      ///< As logged: 0 where the axis took no part in the approach.
  double value_mm = 0;
  double trigger_mm = 0;  ///< Of a touch, value before noise: where along n it ended.
  bool is_outlier = false;
};

/// A machine that performs a plan: it moves point by point through its own play, and a
/// touch ends where the tip, pushed on, has bent by the pre-travel.
class Machine {
 public:
  Machine(const Drawing& drawing, const Truth& truth);

  /// Noise-free readings of all stops. `times_s` is when each is taken.
  std::vector<Reading> Perform(const Plan& plan, const std::vector<double>& times_s);

 private:
  struct Carriage {
    double commanded_mm = 0;
    double lag_mm = 0;  ///< Carriage minus commanded, within +- half the gap.
    double dir = 1;
    double since_rev_mm = 1e3;
  };
  using Carriages = std::array<Carriage, 3>;

  double Gap_mm(int axis, double q_mm) const;
  void MoveAxis(int axis, double to_mm, Carriage* carriage) const;
  Carriages Moved(Carriages carriages, const Vector3& to_mm) const;
  Vector3 Tip_mm(const Carriages& carriages, const Instant& instant) const;
  Instant InstantOf(const Stop& stop, const Carriages& carriages, double t_s) const;
  double Pretravel_mm(const Instant& instant) const;
  double Clearance_mm(const Stop& stop, const Vector3& tip_mm, const Instant& at) const;
  Reading Gauge(const Stop& stop, double t_s);
  Reading Touch(const Stop& stop, double t_s);

  Drawing drawing_;
  Truth truth_;
  const Plan* plan_ = nullptr;
  Carriages carriages_{};
  int home_ = 0;
  double homed_t_s_ = 0;
};

/// When each stop is read, from what moving, probing, homing and setting up take.
std::vector<double> TimesOf_s(const Plan& plan);

}  // namespace blind

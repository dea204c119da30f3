#pragma once

#include <array>

#include "sim/firmware/plant.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {

/// A delta without any error but its bed's height, for tests.
class DeltaBedPlant : public Plant {
 public:
  DeltaBedPlant(const DeltaModel<double>& built,
                double bed_mm,
                double steps_per_mm = 80)
      : built_(built), bed_mm_(bed_mm), steps_per_mm_(steps_per_mm) {}

  Outcome Run(const Segment& segment, const Watch& watch) override {
    const double end_s = segment.profile.Duration_s();
    if (watch.kind == Watch::Kind::kSwitchClosed) {
      return {.stopped = true, .time_s = end_s, .stand_steps = Motors::Zero(3)};
    }
    if (watch.kind != Watch::Kind::kProbeTriggered || Over_mm(segment, end_s) > 0) {
      return {.time_s = end_s};
    }
    double before_s = 0, after_s = end_s;
    for (int i = 0; i < 60; ++i) {
      const double middle_s = (before_s + after_s) / 2;
      (Over_mm(segment, middle_s) <= 0 ? after_s : before_s) = middle_s;
    }
    return {.stopped = true, .time_s = after_s};
  }
  void Settle(const Motors& /*steps*/) override {}
  void Dwell(double /*s*/) override {}
  bool ProbeTriggered() override { return false; }
  bool SwitchClosed(Axis /*axis*/) override { return false; }

 private:
  double Over_mm(const Segment& segment, double t_s) const {
    const Vec3<double> motors_mm = segment.Steps(t_s) / steps_per_mm_;
    return DeltaNozzle_mm(built_, motors_mm)[2] - bed_mm_;
  }
  DeltaModel<double> built_;
  double bed_mm_, steps_per_mm_;
};

}  // namespace caltwin

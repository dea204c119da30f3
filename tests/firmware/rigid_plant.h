#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "sim/firmware/plant.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// A machine without any error, for tests: the tip is where the steps say. Its probe
/// triggers as soon as the tip is at a wall, moving in + along one axis.
class RigidPlant : public Plant {
 public:
  explicit RigidPlant(const Machine& machine) : machine_(machine) {}

  Outcome Run(const Segment& segment, const Watch& watch) override {
    segments.push_back(segment);
    const double end_s = segment.profile.Duration_s();
    Outcome outcome{.time_s = end_s};
    const auto is_over = [&](double t_s) {
      const Vec3<double> tip_mm = TipAt(segment.Steps(t_s));
      switch (watch.kind) {
        case Watch::Kind::kNothing:
          return tip_mm[Index(wall_axis)] > alarm_mm;
        case Watch::Kind::kProbeTriggered:
          return TouchesWall(tip_mm);
        case Watch::Kind::kProbeReleased:
          return !TouchesWall(tip_mm);
        case Watch::Kind::kSwitchClosed:
          return IsAtHome(watch.axis, tip_mm);
        case Watch::Kind::kSwitchOpened:
          return !IsAtHome(watch.axis, tip_mm);
      }
      return false;
    };
    if (is_over(end_s)) {
      double before_s = 0;
      double after_s = end_s;
      for (int i = 0; i < 60; ++i) {
        const double middle_s = (before_s + after_s) / 2;
        (is_over(middle_s) ? after_s : before_s) = middle_s;
      }
      outcome.time_s = after_s;
      outcome.stopped = watch.kind != Watch::Kind::kNothing;
      if (!outcome.stopped) outcome.alarm = "the stylus was bent beyond its overtravel";
    }
    steps = segment.Steps(outcome.time_s);
    return outcome;
  }
  void Settle(const Motors& whole) override {
    largest_settling_steps =
        std::max(largest_settling_steps, (whole - steps).cwiseAbs().maxCoeff());
    steps = whole;
  }
  void Dwell(double s) override { dwelt_s += s; }
  bool ProbeTriggered() override { return TouchesWall(TipAt(steps)); }
  bool SwitchClosed(Axis axis) override { return IsAtHome(axis, TipAt(steps)); }

  Axis wall_axis = Axis::kX;
  double wall_mm = 1e9;   ///< The probe is triggered beyond.
  double alarm_mm = 1e9;  ///< A plain move beyond bends the stylus.
  Vec3<double> steps = Vec3<double>::Zero();
  std::vector<Segment> segments{};
  double dwelt_s = 0;
  double largest_settling_steps = 0;

 private:
  Vec3<double> TipAt(const Vec3<double>& motor_steps) const {
    Vec3<double> tip_mm;
    for (const Axis axis : kAxes) {
      const AxisDrawing& drawing = machine_.axis(axis);
      tip_mm[Index(axis)] =
          drawing.home_mm() + motor_steps[Index(axis)] / drawing.steps_per_mm();
    }
    return tip_mm;
  }
  bool TouchesWall(const Vec3<double>& tip_mm) const {
    return tip_mm[Index(wall_axis)] >= wall_mm;
  }
  bool IsAtHome(Axis axis, const Vec3<double>& tip_mm) const {
    const AxisDrawing& drawing = machine_.axis(axis);
    return drawing.home == HomeEnd::kMin ? tip_mm[Index(axis)] <= drawing.min_mm
                                         : tip_mm[Index(axis)] >= drawing.max_mm;
  }

  Machine machine_;
};

/// Three axes of 300 mm at 800 steps/mm, 100 mm/s and 500 mm/s^2; z homes to its top.
inline Machine TestMachine() {
  Machine machine;
  machine.name = "test";
  machine.axes[2].home = HomeEnd::kMax;
  machine.settings.steps_per_mm = {800, 800, 800};
  return machine;
}

}  // namespace caltwin

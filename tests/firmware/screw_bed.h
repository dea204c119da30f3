#pragma once

#include <algorithm>
#include <functional>

#include "sim/firmware/firmware.h"
#include "sim/firmware/plant.h"
#include "sim/machine/kinds/triple_z/drawing.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// A printer without any error but its bed's, for tests: x and y at 80 steps/mm, three
/// screws at 800, a bed that stands wherever a function of the screws says.
class ScrewBed : public Plant {
 public:
  /// Height at which the bed is touched over a place, each screw raised by so much.
  using Height =
      std::function<double(const Vec3<double>& raised_mm, double x, double y)>;
  explicit ScrewBed(Height height) : height_(std::move(height)) {}

  Outcome Run(const Segment& segment, const Watch& watch) override {
    const double end_s = segment.profile.Duration_s();
    const auto is_over = [&](double t_s) {
      steps_ = segment.Steps(t_s);
      if (watch.kind == Watch::Kind::kProbeTriggered) return ProbeTriggered();
      return watch.kind == Watch::Kind::kSwitchClosed && SwitchClosed(watch.axis);
    };
    if (!is_over(end_s)) return {.time_s = end_s};
    double before_s = 0, after_s = end_s;
    for (int i = 0; i < 60; ++i) {
      const double middle_s = (before_s + after_s) / 2;
      (is_over(middle_s) ? after_s : before_s) = middle_s;
    }
    steps_ = segment.Steps(after_s);
    if (watch.kind != Watch::Kind::kSwitchClosed || watch.axis != Axis::kZ) {
      return {.stopped = true, .time_s = after_s};
    }
    // Each screw has stopped at its own switch.
    steps_.tail<kNumScrews>().setZero();
    return {.stopped = true, .time_s = after_s, .stand_steps = steps_};
  }
  void Settle(const Motors& steps) override { steps_ = steps; }
  void Dwell(double /*s*/) override {}
  bool ProbeTriggered() override {
    const Vec3<double> screws_mm = -steps_.tail<kNumScrews>() / 800;
    const double z_mm = 250 - screws_mm.mean();
    const Vec3<double> raised_mm = screws_mm.array() - screws_mm.mean();
    return z_mm <= height_(raised_mm, steps_[0] / 80, steps_[1] / 80);
  }
  bool SwitchClosed(Axis axis) override {
    return axis == Axis::kZ ? steps_.tail<kNumScrews>().minCoeff() >= 0
                            : steps_[Index(axis)] <= 0;
  }

 private:
  Height height_;
  Motors steps_ = Motors::Zero(2 + kNumScrews);
};

/// The machine that a ScrewBed is.
inline Machine ScrewBedMachine() {
  return ReadMachine(ShareFolder() / "models/triple_z_printer/machine.yaml");
}

}  // namespace caltwin

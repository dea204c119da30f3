#include <algorithm>
#include <cmath>

#include "sim/base/mutant.h"
#include "sim/firmware/motor_motion.h"

namespace caltwin {
namespace {

constexpr double kPatience_s = 0.5;
constexpr double kAfterwards_s = 0.05;  // Counters are watched so long without power.
constexpr double kStill_pulses = 1.5;   // A tick: slower counts as standing,
constexpr double kHeld_s = 0.002;       // and is braked so long yet.

}  // namespace

RigDrives MotorMotion::Stopping(double t_s, const Slowings& slowing) {
  RigDrives drives = Holding();
  const double braked_s = t_s - options_.stop_filter_s;
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    if (!axes_[i].is_enabled) continue;
    if (options_.is_servo[i] && braked_s >= 0) {
      drives[i].mode = RigDrive::Mode::kBrake;
      continue;
    }
    const double ramp_s = std::max(options_.stepper_stop_s, tick_s_);
    const double ramp = std::clamp(1 - braked_s / ramp_s, 0.0, 1.0);
    axes_[i].target_pulses += slowing[i].speed_pulses_s * ramp * tick_s_;
    drives[i].to_pulses = axes_[i].target_pulses;
  }
  return drives;
}

// It stands within the tick that ends at `t_s`: when, from how it slowed before.
void MotorMotion::NoteStandstill(std::size_t i, double t_s, Slowing* slowing) {
  StopReport& stop = axes_[i].stop;
  const double first = slowing->speed_pulses_s;
  const double now = static_cast<double>(rig_->Count(i) - count_before_[i]) / tick_s_;
  const bool stands = now * first <= 0 || std::abs(now) * tick_s_ < kStill_pulses;
  if (!stop.is_done && t_s > options_.stop_filter_s && stands) {
    const double lost = std::abs(slowing->before) - std::abs(slowing->last);
    double part = 1;
    if (lost > 0) part = std::clamp(std::abs(slowing->last) / lost - 0.5, 0.0, 1.0);
    stop = {.standstill_s = first == 0 ? 0 : t_s - tick_s_ * (1 - part),
            .path_pulses =
                std::abs(static_cast<double>(rig_->Count(i)) - slowing->from_pulses),
            .is_done = true};
  }
  slowing->before = slowing->last;
  slowing->last = now;
}

void MotorMotion::EmergencyStop() {
  Slowings slowing{};
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    const double speed =
        static_cast<double>(rig_->Count(i) - count_before_[i]) / tick_s_;
    slowing[i] = {.from_pulses = static_cast<double>(rig_->Count(i)),
                  .speed_pulses_s = speed,
                  .last = speed,
                  .before = speed};
    axes_[i].stop = {};
    axes_[i].peak_a = 0;
  }
  const double least_s = options_.stop_filter_s + options_.stepper_stop_s;
  double stood_s = 0;
  for (double t_s = 0; stood_s < kHeld_s && t_s < kPatience_s;) {
    Tick(Stopping(t_s, slowing));
    t_s += tick_s_;
    bool all_stand = t_s > least_s;
    for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
      NoteStandstill(i, t_s, &slowing[i]);
      all_stand = all_stand && axes_[i].stop.is_done;
    }
    if (all_stand) stood_s += tick_s_;
  }
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    axes_[i].stop.peak_a = axes_[i].peak_a;
    axes_[i].is_enabled = false;
    axes_[i].at_limit_s = 0;
  }
  is_stopped_ = Mutant("motor_stop_not_latched", true, false);
  Wait(kAfterwards_s);
}

}  // namespace caltwin

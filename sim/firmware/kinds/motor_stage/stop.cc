#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "sim/firmware/kinds/motor_stage/motion.h"
#include "sim/firmware/standstill.h"

namespace caltwin {
namespace {

constexpr double kPatience_s = 0.5;
constexpr double kAfterwards_s = 0.05;  // Counters are watched so long without power.
// Within a pulse for so long it stands. A load that coasts across a gap of 0.2 mm
// at 5 mm/s or more has arrived by then: it would push a drive without power on.
constexpr double kHeld_s = 0.04;

}  // namespace

// From now until the input's filter lets the contact through.
int MotorMotion::FilterTicks(double since_s) const {
  constexpr double kWhole = 1e-6;
  const double left_s = options_.stop_filter_s - since_s;
  return std::max(0, static_cast<int>(std::ceil(left_s / tick_s_ - kWhole)));
}

// Until the input's filter lets the contact through, all go on as they were told.
RigDrives MotorMotion::Stopping(double braked_s, const Slowings& slowings) {
  RigDrives drives = Holding();
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    if (!axes_[i].is_enabled) continue;
    if (options_.is_servo[i] && braked_s >= 0) {
      drives[i].mode = RigDrive::Mode::kBrake;
      continue;
    }
    const double ramp_s = std::max(options_.stepper_stop_s, tick_s_);
    const double ramp = std::clamp(1 - braked_s / ramp_s, 0.0, 1.0);
    axes_[i].target_pulses += slowings[i].told_pulses_s * ramp * tick_s_;
    drives[i].to_pulses = axes_[i].target_pulses;
  }
  return drives;
}

void MotorMotion::WatchStop(bool brakes, Slowings* slowings) {
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    Slowing& slowing = (*slowings)[i];
    const std::int64_t count = rig_->Count(i);
    // The last before the brakes act is their onset.
    if (!brakes) slowing.counts.clear();
    slowing.counts.push_back(count);
    const bool is_near = std::abs(count - slowing.near) <= 1;
    if (!is_near) slowing.near = count;
    slowing.still_s = is_near ? slowing.still_s + tick_s_ : 0;
  }
}

// @param brakes_at_s  from the contact to where brakes and ramps begin
StopReport MotorMotion::ReportOf(std::size_t i,
                                 const Slowing& slowing,
                                 double brakes_at_s) const {
  StopReport report{
      .brakes_at_s = brakes_at_s,
      .told_pulses_s = slowing.told_pulses_s,
      .path_pulses = std::abs(static_cast<double>(rig_->Count(i) - slowing.from)),
      .peak_a = axes_[i].peak_a,
      .is_done = slowing.still_s >= kHeld_s};
  if (slowing.told_pulses_s == 0) return report;
  const Standstill braked =
      options_.is_servo[i]
          ? StandstillOf(slowing.counts, tick_s_, slowing.told_pulses_s)
          : Standstill{.at_s = options_.stepper_stop_s};
  report.standstill_s = brakes_at_s + braked.at_s;
  report.sd_s = braked.sd_s;
  report.rests_s = brakes_at_s + braked.rests_at_s;
  report.is_knocked = braked.is_knocked;
  return report;
}

void MotorMotion::EmergencyStop(double since_s) {
  Slowings slowings{};
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    slowings[i].told_pulses_s = axes_[i].told_pulses_s;
    slowings[i].from = rig_->Count(i);
    slowings[i].near = slowings[i].from;
    axes_[i].peak_a = 0;
  }
  const int filter_ticks = FilterTicks(since_s);
  bool all_stand = false;
  const int most = static_cast<int>(std::ceil(kPatience_s / tick_s_));
  for (int tick = 0; !all_stand && tick < most; ++tick) {
    const double braked_s = (tick - filter_ticks) * tick_s_;
    Tick(Stopping((tick - filter_ticks) * tick_s_, slowings));
    WatchStop(tick >= filter_ticks, &slowings);
    all_stand = braked_s >= options_.stepper_stop_s &&
                std::ranges::all_of(slowings, [](const Slowing& each) {
                  return each.still_s >= kHeld_s;
                });
  }
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    axes_[i].stop = ReportOf(i, slowings[i], since_s + filter_ticks * tick_s_);
    axes_[i].is_enabled = false;
    axes_[i].at_limit_s = 0;
  }
  is_stopped_ = true;
  Wait(kAfterwards_s);
}

}  // namespace caltwin

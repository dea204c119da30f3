#include "scenarios/kinds/motor_stage_wire.h"

#include <cmath>

#include <fmt/format.h>

#include "sim/base/input_error.h"

namespace caltwin {
namespace {

std::int32_t Whole(double pulses) {
  return static_cast<std::int32_t>(std::lround(pulses));
}

AxisCalibration FactoryOf(const MotorAxisDrawing& d) {
  const double pulses = d.pulses_per_unit();
  return {.pulses_per_unit = pulses,
          .pulses_per_rev = static_cast<std::uint32_t>(std::lround(d.pulses_per_rev)),
          .min_position_pulses = Whole(d.min_unit * pulses),
          .max_position_pulses = Whole(d.max_unit * pulses),
          .index_enabled = d.is_servo,
          .max_velocity_pulses_s = d.max_velocity_unit_s * pulses,
          .max_acceleration_pulses_s2 = d.acceleration_unit_s2 * pulses};
}

// How much farther a motor has gone than its counter says: of an encoder the pulses it
// lost (to a pulse; 0 where none), of a stepper whole magnetic cycles that it let go.
double LostPulses(const MotorStageRig& rig, std::size_t axis) {
  const MotorAxisDrawing& d = rig.built().motors[axis].drawing;
  const double from_unit =
      rig.State(axis).motor_unit - rig.built().faults[axis].start_unit;
  const double gone_pulses = from_unit * d.pulses_per_unit();
  const auto counted = static_cast<double>(rig.Count(axis));
  if (d.is_servo) return std::floor(gone_pulses) - counted;
  const double cycle_pulses = 4 * d.pulses_per_rev / d.full_steps_per_rev;
  return cycle_pulses * std::round((gone_pulses - counted) / cycle_pulses);
}

}  // namespace

MotorStageOptions MotorFirmwareOf(const MotorStageDrawing& drawing) {
  MotorStageOptions options;
  options.motion.poll_s = drawing.poll_s;
  options.motion.transfer_s = drawing.transfer_s;
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    options.factory[i] = FactoryOf(drawing.axes[i]);
    options.motion.is_servo[i] = drawing.axes[i].is_servo;
    options.motion.limit_a[i] = drawing.axes[i].current_limit_a;
  }
  return options;
}

Expected<double> MotorStageGauge::Read_mm(std::string_view id) {
  constexpr std::string_view kLaser = "laser.";
  const auto axis =
      id.starts_with(kLaser) ? MotorAxisNamed(id.substr(kLaser.size())) : std::nullopt;
  if (!axis) {
    return tl::unexpected(
        MachineFault{.reply = fmt::format("there is no gauge '{}'", id)});
  }
  return rig_->State(*axis).carriage_unit + sigma_unit_ * noise_.Normal();
}

Expected<void> MotorStageGauge::Zero(std::string_view id) {
  return tl::unexpected(
      MachineFault{.reply = fmt::format("the gauge '{}' has no zero", id)});
}

void SetFields(const MotorStageTruth& truth,
               const std::filesystem::path& file,
               MotorAxes* axes) {
  for (const auto& [code, field] : truth.settings) {
    const auto set = axes->SetField(code, field.first, field.second);
    if (set) continue;
    throw InputError(
        {.file = file.string()},
        fmt::format("settings: the controller refuses M{} of {} = {:g}: {}",
                    code,
                    MotorAxisName(field.first),
                    field.second,
                    set.error().reply));
  }
}

double TrueHome(const MotorStageFirmware& firmware,
                const MotorStageRig& rig,
                std::size_t axis) {
  const MotorAxisDrawing& d = rig.built().motors[axis].drawing;
  const double start_unit = rig.built().faults[axis].start_unit;
  const double lost_pulses = LostPulses(rig, axis);
  // Count 0 begins beside where it stood at power-up (MotorFaults::pulse_part).
  const double zero_pulses = static_cast<double>(firmware.zero_count(axis)) -
                             rig.built().faults[axis].pulse_part;
  return start_unit + (zero_pulses + lost_pulses) / d.pulses_per_unit() -
         d.min_switch_unit;
}

}  // namespace caltwin

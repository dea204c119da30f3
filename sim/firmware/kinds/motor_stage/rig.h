#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "sim/machine/kinds/motor_stage/drawing.h"

namespace caltwin {

/// Which of an axis' two switches.
enum class SwitchEnd : std::uint8_t { kMin, kMax };

/// What the drive of an axis is told for a tick.
struct RigDrive {
  enum class Mode { kOff, kFollow, kBrake };
  Mode mode = Mode::kOff;
  double to_pulses = 0;  ///< Of the counter at the tick's end; a stepper's field.
};
using RigDrives = std::array<RigDrive, kNumMotorAxes>;

/// What a motor controller's terminals are wired to.
class MotorRig {
 public:
  virtual ~MotorRig() = default;
  virtual double tick_s() const = 0;
  /// Lets a tick pass.
  virtual void Tick(const RigDrives& drives) = 0;
  /// Of a servo its encoder's counter since power-up, of a stepper the pulses sent.
  virtual std::int64_t Count(std::size_t axis) const = 0;
  /// What its drive feeds the motor now [A].
  virtual double CurrentOf(std::size_t axis) const = 0;
  /// The level at the expander's pin now.
  virtual bool IsPressed(std::size_t axis, SwitchEnd end) const = 0;
  /// Counts that the hardware latched at index pulses since the last call, in order.
  virtual std::vector<std::int64_t> TakeIndexEdges(std::size_t axis) = 0;
};

}  // namespace caltwin

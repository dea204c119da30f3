#pragma once

#include <array>

#include "sim/machine/kinds/motor_stage/built.h"

namespace caltwin {

/// What the drive of an axis shall do until the next tick.
struct MotorDrive {
  enum class Mode {
    kOff,     ///< No current: the axis coasts and stays where friction leaves it.
    kFollow,  ///< To `to_unit` at the tick's end.
    kBrake    ///< To a standstill with all the current there is; a stepper holds.
  };
  Mode mode = Mode::kOff;
  double to_unit = 0;  ///< Of the motor, in travel; of a stepper the field.
};
using MotorDrives = std::array<MotorDrive, kNumMotorAxes>;

/// One axis at an instant.
struct MotorState {
  double motor_unit = 0;
  double motor_unit_s = 0;
  double carriage_unit = 0;
  double force = 0;  ///< The motor's [N, N m].
};

/// Motors, gaps and carriages that are driven tick by tick: MuJoCo, or closed form.
///
/// A servo drive follows exactly as long as the force suffices that its current limit
/// leaves: F = M (s - q - v dt) / dt^2, clamped, M the motor's inertia and the load's
/// (across a gap half of it, which the motor feels at times only). A stepper's rotor
/// hangs on its field as on a spring that lets go: F = -H sin(2 pi (q - s) / cycle), H
/// what it holds, falling to half at the highest feed, cycle four full steps.
class MotorMechanism {
 public:
  explicit MotorMechanism(const BuiltMotors& motors) : motors_(motors) {}
  virtual ~MotorMechanism() = default;
  MotorMechanism(const MotorMechanism&) = delete;
  MotorMechanism& operator=(const MotorMechanism&) = delete;

  static constexpr double kTick_s = 0.00025;

  /// Puts the axis there, at rest, its carriage in the middle of the gap.
  virtual void Place(std::size_t axis, double motor_unit) = 0;
  virtual void Tick(const MotorDrives& drives) = 0;
  virtual MotorState State(std::size_t axis) const = 0;

  const BuiltMotor& motor(std::size_t axis) const { return motors_[axis]; }

 protected:
  BuiltMotors motors_;
};

/// Travel of a stepper's magnetic cycle: four full steps.
double MagneticCycle(const MotorAxisDrawing& drawing);

/// The largest force [N, N m] a stepper's rotor is held with while its field moves at
/// that speed.
double HoldingForce(const MotorAxisDrawing& drawing, double field_unit_s);

/// Closed form: motors where they are told to be, or as far as constant force takes
/// them; carriages by the play operator; a stepper's rotor lags its field by the angle
/// that carries the load. Exact without a gap; across one it leaves out that a motor
/// alone is lighter, and that a carriage coasts.
class FastMotors : public MotorMechanism {
 public:
  explicit FastMotors(const BuiltMotors& motors) : MotorMechanism(motors) {}

  void Place(std::size_t axis, double motor_unit) override;
  void Tick(const MotorDrives& drives) override;
  MotorState State(std::size_t axis) const override { return axes_[axis].state; }

 private:
  struct AxisNow {
    MotorState state{};
    double field_unit = 0, field_unit_s = 0;
    double lost_unit = 0;      ///< By which the rotor is behind its field for good.
    bool has_slipped = false;  ///< And has not caught it again.
  };
  static bool IsResting(const AxisNow& now, const MotorDrive& drive);
  void Servo(const BuiltMotor& motor, const MotorDrive& drive, AxisNow* now) const;
  void Stepper(const BuiltMotor& motor, const MotorDrive& drive, AxisNow* now) const;
  void Slip(const BuiltMotor& motor, AxisNow* now) const;
  void Coast(const BuiltMotor& motor, double force, AxisNow* now) const;
  void StopAtEnds(const BuiltMotor& motor, AxisNow* now) const;

  std::array<AxisNow, kNumMotorAxes> axes_{};
};

}  // namespace caltwin

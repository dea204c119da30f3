#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "sim/base/rng.h"
#include "sim/firmware/kinds/motor_stage/rig.h"
#include "sim/kinds/motor_stage/mechanism.h"

namespace caltwin {

/// What is wrong with an axis' sensors and wires; its mechanics are in BuiltMotor.
struct MotorFaults {
  double switch_scatter_unit = 0;  ///< Standard deviation from one closing to the next.
  bool min_switch_missing = false, max_switch_missing = false;
  /// Faster, no index pulse comes through; 0: none at all; nullopt: all do.
  std::optional<double> index_lost_above_unit_s{};
  double pulses_lost = 0;               ///< Part of the encoder's pulses that is lost
  double pulses_lost_above_unit_s = 0;  ///< above that speed.
  double start_delay_s = 0;             ///< Of the drive against the controller.
  double start_unit = 50;               ///< Where it stands at power-up.
  double pulse_part =
      0;  ///< Of a pulse, that it stands beyond the counter's edge there.
};

/// A motor stage as it is built: what its controller cannot know.
struct BuiltMotorStage {
  MotorStageDrawing drawing{};
  BuiltMotors motors{};
  std::array<MotorFaults, kNumMotorAxes> faults{};
};

/// The terminals of a simulated motor stage: counters, switches, index pulses,
/// currents.
///
/// Switches close where the carriage passes them on its way to them, each time at
/// another place by their scatter (one drawn for each approach, whatever came before),
/// and open their hysteresis later. A servo at rest stands within 0.8 of a
/// pulse of where it is told to.
class MotorStageRig : public MotorRig {
 public:
  /// @param is_physics  MuJoCo moves the axes
  MotorStageRig(const BuiltMotorStage& built,
                bool is_physics,
                std::uint64_t seed,
                std::uint64_t sample);

  double tick_s() const override { return MotorMechanism::kTick_s; }
  void Tick(const RigDrives& drives) override;
  std::int64_t Count(std::size_t axis) const override { return axes_[axis].count; }
  double CurrentOf(std::size_t axis) const override;
  bool IsPressed(std::size_t axis, SwitchEnd end) const override;
  std::vector<std::int64_t> TakeIndexEdges(std::size_t axis) override;

  /// @name The truth
  MotorState State(std::size_t axis) const { return mechanism_->State(axis); }
  const BuiltMotorStage& built() const { return built_; }
  /// Puts an axis elsewhere, at rest, as a person's hand would: its counter follows.
  void MoveByHand(std::size_t axis, double to_unit);

 private:
  struct Switch {
    bool is_closed = false;
    double scatter_unit = 0;  ///< Of its next closing.
  };
  struct AxisNow {
    std::int64_t count = 0;
    double lost_pulses = 0;
    double rest_pulses = 0, rest_goal_pulses = 0;
    double last_told = 0;
    std::optional<double> sensed_unit{};  ///< Where the carriage was looked at last.
    bool was_moving = false;
    std::vector<double> delayed{};  ///< Drives told and not yet obeyed, oldest first.
    double delay_part = 0;          ///< Of a tick, beyond whole ones.
    std::array<Switch, 2> switches{};
    std::vector<std::int64_t> edges{};
  };
  double PulsesAt(std::size_t axis, double motor_unit) const;
  MotorDrive DriveOf(std::size_t axis, const RigDrive& told);
  void Rest(std::size_t axis, double told);
  void SenseIndex(std::size_t axis, double before_unit, double now_unit);
  void SenseSwitch(std::size_t axis,
                   SwitchEnd end,
                   std::optional<double> before_unit,
                   double carriage_unit);
  void SenseAll(std::size_t axis, const MotorState& before);

  BuiltMotorStage built_;
  std::unique_ptr<MotorMechanism> mechanism_;
  std::array<AxisNow, kNumMotorAxes> axes_{};
  Rng switch_scatter_, rest_;
};

}  // namespace caltwin

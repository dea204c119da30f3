#pragma once

#include <cmath>
#include <optional>

#include "scenarios/motor_link.h"

namespace caltwin {

inline MotorStageDrawing DrawnMotorStage() {
  return ReadMotorStage(CALTWIN_SOURCE_DIR "/models/motor_stage/machine.yaml");
}

inline BuiltMotorStage BuiltAsDrawn(const MotorStageDrawing& drawing) {
  BuiltMotorStage built{.drawing = drawing};
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    built.motors[i].drawing = drawing.axes[i];
  }
  return built;
}

/// Passes everything on, and notes when x truly stood after its drive braked: when the
/// momentum of motor and carriage was gone. Each alone swings about it in the coupling.
class WatchedRig : public MotorRig {
 public:
  WatchedRig(MotorStageRig* inner, const MotorAxisDrawing& built)
      : inner_(inner), built_(built) {}

  double tick_s() const override { return inner_->tick_s(); }
  void Tick(const RigDrives& drives) override {
    const double carriage_unit = inner_->State(0).carriage_unit;
    inner_->Tick(drives);
    const MotorState state = inner_->State(0);
    const double speed_unit_s = (state.carriage_unit - carriage_unit) / tick_s();
    Note(drives[0].mode == RigDrive::Mode::kBrake,
         std::abs(built_.motor_inertia * state.motor_unit_s +
                  built_.load_inertia * speed_unit_s));
  }
  std::int64_t Count(std::size_t axis) const override { return inner_->Count(axis); }
  double CurrentOf(std::size_t axis) const override { return inner_->CurrentOf(axis); }
  bool IsPressed(std::size_t axis, SwitchEnd end) const override {
    return inner_->IsPressed(axis, end);
  }
  std::vector<std::int64_t> TakeIndexEdges(std::size_t axis) override {
    return inner_->TakeIndexEdges(axis);
  }

  /// From where the brakes acted, the input's filter not counted.
  std::optional<double> braked_s() const { return braked_s_; }

 private:
  // MuJoCo's speeds are those in the middle of a tick. A drive holds its force for a
  // tick: it stood when the force of the tick before would have ended its momentum.
  void Note(bool brakes, double momentum) {
    constexpr double kGone = 0.001;
    if (brakes && !braked_s_) {
      if (ticks_ == 0) first_ = before_;
      ++ticks_;
      if (momentum < kGone * first_) {
        const double full = std::max(earlier_ - before_, before_ - momentum);
        braked_s_ = tick_s() * (ticks_ - 1.5 + before_ / full);
      }
    }
    earlier_ = before_;
    before_ = momentum;
  }

  MotorStageRig* inner_;
  MotorAxisDrawing built_;
  double earlier_ = 0, before_ = 0, first_ = 0;
  int ticks_ = 0;
  std::optional<double> braked_s_{};
};

/// A simulated stage with its controller, and what calibration has of it.
struct MotorBenchInATest {
  explicit MotorBenchInATest(const BuiltMotorStage& built,
                             bool is_physics = false,
                             std::uint64_t seed = 1,
                             std::uint64_t sample = 0)
      : rig(built, is_physics, seed, sample),
        watched(&rig, built.motors[0].drawing),
        firmware(MotorFirmwareOf(built.drawing), &watched, &flash),
        wire(&firmware),
        gauge(&rig, 0.0005, seed, sample),
        axes({.link = &wire, .gauge = &gauge, .drawing = built.drawing}) {}

  /// Without power, by hand, with power again.
  void MoveByHand(std::size_t axis, double to_unit) {
    axes.Enable(axis, false);
    rig.MoveByHand(axis, to_unit);
    axes.Enable(axis, true);
  }

  MotorStageRig rig;
  WatchedRig watched;
  Flash flash{};
  MotorStageFirmware firmware;
  MotorStageWire wire;
  MotorStageGauge gauge;
  MotorAxes axes;
};

}  // namespace caltwin

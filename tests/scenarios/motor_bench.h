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

/// Passes everything on, and notes when x truly stood after its drive braked.
class WatchedRig : public MotorRig {
 public:
  explicit WatchedRig(MotorStageRig* inner) : inner_(inner) {}

  double tick_s() const override { return inner_->tick_s(); }
  void Tick(const RigDrives& drives) override {
    const double before = std::abs(inner_->State(0).motor_unit_s);
    inner_->Tick(drives);
    const double after = std::abs(inner_->State(0).motor_unit_s);
    if (drives[0].mode != RigDrive::Mode::kBrake || braked_s_) return;
    if (!slowing_s_) {
      slowing_s_ = 0;
      first_ = before;
    }
    *slowing_s_ += tick_s();
    // At a hundredth of its speed its coupling begins to ring: when it stands follows
    // from how it slowed.
    if (after > 0.01 * first_) return;
    braked_s_ = *slowing_s_ + tick_s() * (before / (before - after) - 1);
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
  MotorStageRig* inner_;
  std::optional<double> slowing_s_{}, braked_s_{};
  double first_ = 0;
};

/// A simulated stage with its controller, and what calibration has of it.
struct MotorBenchInATest {
  explicit MotorBenchInATest(const BuiltMotorStage& built,
                             bool is_physics = false,
                             std::uint64_t seed = 1,
                             std::uint64_t sample = 0)
      : rig(built, is_physics, seed, sample),
        watched(&rig),
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

#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "scenarios/kinds/motor_stage_wire.h"

namespace caltwin {

inline MotorStageDrawing DrawnMotorStage() {
  static const MotorStageDrawing drawing =
      MotorStageOf(ReadMachine(CALTWIN_SOURCE_DIR "/models/motor_stage/machine.yaml"));
  return drawing;
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
/// Across a gap when either had stopped: slower than a twentieth of the momentum for
/// good, with what was left of it at the last rate. (Rattling inside the gap with less
/// is not counted.)
class WatchedRig : public MotorRig {
 public:
  WatchedRig(MotorStageRig* inner, const BuiltMotor& built)
      : inner_(inner), built_(built) {}

  double tick_s() const override { return inner_->tick_s(); }
  void Tick(const RigDrives& drives) override {
    WatchContact(drives[0]);
    const double carriage_unit = inner_->State(0).carriage_unit;
    inner_->Tick(drives);
    const MotorState state = inner_->State(0);
    const double motor = built_.drawing.motor_inertia * state.motor_unit_s;
    const double carriage =
        built_.drawing.load_inertia * (state.carriage_unit - carriage_unit) / tick_s();
    const double momentum = built_.gap_unit > 0 ? std::abs(motor) + std::abs(carriage)
                                                : std::abs(motor + carriage);
    Note(drives[0].mode, momentum);
  }
  std::int64_t Count(std::size_t axis) const override { return inner_->Count(axis); }
  double CurrentOf(std::size_t axis) const override { return inner_->CurrentOf(axis); }
  bool IsPressed(std::size_t axis, SwitchEnd end) const override {
    return inner_->IsPressed(axis, end);
  }
  std::vector<std::int64_t> TakeIndexEdges(std::size_t axis) override {
    return inner_->TakeIndexEdges(axis);
  }

  /// The relay on the stop's input opens so long after x begins its next move.
  void Arm(double after_s) { armed_s_ = after_s; }
  /// From when that contact opened.
  std::optional<double> stood_s() const {
    const auto braked = braked_s();
    if (!braked || !contact_s_) return std::nullopt;
    return brakes_at_s_ - *contact_s_ + *braked;
  }
  /// From where the brakes acted.
  std::optional<double> braked_s() const {
    const double gone = (built_.gap_unit > 0 ? 0.05 : 0.001) * Momentum(0);
    const std::size_t end = momenta_.size();
    std::size_t at = 1;
    if (built_.gap_unit > 0) {
      at = end;
      while (at > 1 && Momentum(at - 1) < gone) --at;
    } else {
      while (at < end && Momentum(at) >= gone) ++at;
    }
    if (at >= end) return std::nullopt;
    // MuJoCo's speeds are those in the middle of a tick. A drive holds its force for a
    // tick: it stood when the force of the tick before would have ended its momentum.
    const double earlier = Momentum(at > 1 ? at - 2 : 0), before = Momentum(at - 1);
    const double full = std::max(earlier - before, before - Momentum(at));
    return tick_s() * (static_cast<double>(at) - 1.5 + before / full);
  }

 private:
  double Momentum(std::size_t tick) const {
    return tick < momenta_.size() ? momenta_[tick] : 0;
  }
  // A move begins with the first tick that tells x to be elsewhere.
  void WatchContact(const RigDrive& drive) {
    const bool begins = drive.to_pulses != told_pulses_ && armed_s_.has_value();
    if (begins) contact_s_ = time_s_ + *std::exchange(armed_s_, std::nullopt);
    told_pulses_ = drive.to_pulses;
    const bool is_first = drive.mode == RigDrive::Mode::kBrake && momenta_.empty();
    if (is_first) brakes_at_s_ = time_s_;
    time_s_ += tick_s();
  }
  // From the tick before the brakes on, until the drive is told to follow again.
  void Note(RigDrive::Mode mode, double momentum) {
    if (mode == RigDrive::Mode::kBrake && momenta_.empty()) momenta_ = {before_};
    is_over_ = is_over_ || (!momenta_.empty() && mode == RigDrive::Mode::kFollow);
    if (!momenta_.empty() && !is_over_) momenta_.push_back(momentum);
    before_ = momentum;
  }

  MotorStageRig* inner_;
  BuiltMotor built_;
  double time_s_ = 0, brakes_at_s_ = 0, told_pulses_ = 0;
  std::optional<double> armed_s_{}, contact_s_{};
  double before_ = 0;
  std::vector<double> momenta_{};
  bool is_over_ = false;
};

/// Passes lines on, and tells the rig of the relay that they arm (M817 S0.1).
class ArmingLink : public Link {
 public:
  ArmingLink(Link* inner, WatchedRig* watched) : inner_(inner), watched_(watched) {}
  Expected<std::vector<std::string>> Send(std::string_view line,
                                          std::chrono::milliseconds patience) override {
    constexpr std::string_view kArms = "M817 S";
    if (line.starts_with(kArms)) {
      watched_->Arm(std::stod(std::string(line.substr(kArms.size()))));
    }
    return inner_->Send(line, patience);
  }

 private:
  Link* inner_;
  WatchedRig* watched_;
};

/// A simulated stage with its controller, and what calibration has of it.
struct MotorBenchInATest {
  explicit MotorBenchInATest(const BuiltMotorStage& built,
                             bool is_physics = false,
                             std::uint64_t seed = 1,
                             std::uint64_t sample = 0)
      : rig(built, is_physics, seed, sample),
        watched(&rig, built.motors[0]),
        firmware(MotorFirmwareOf(built.drawing), &watched, &flash),
        wire(&firmware),
        gauge(&rig, 0.0005, seed, sample),
        arming(&wire, &watched),
        axes({.link = &arming, .gauge = &gauge, .drawing = built.drawing}) {}

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
  EmulatedLink wire;
  MotorStageGauge gauge;
  ArmingLink arming;
  MotorAxes axes;
};

}  // namespace caltwin

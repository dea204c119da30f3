#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "sim/base/rng.h"
#include "sim/firmware/firmware.h"
#include "sim/firmware/plant.h"
#include "sim/firmware/stepped_plant.h"
#include "sim/kinds/triple_z/machine.h"

namespace caltwin {

/// A triple-Z printer as it is built: what its firmware cannot know.
struct BuiltTripleZ {
  Machine machine{};
  std::vector<Injected> effects{};
  double scatter_mm = 0;  ///< Of the trigger, beside `trigger_scatter`.
};

/// A simulated printer whose bed stands on three screws and can be raised to its
/// nozzle, in closed form or MuJoCo. Motors: two of the head, x y or the belts a b,
/// then z1 z2 z3, each screw with a switch at its lower end. Between touches it is
/// where its motors are.
class TripleZTwinPlant final : public Plant, public SteppedPlant {
 public:
  /// @param is_physics  MuJoCo finds the trigger
  TripleZTwinPlant(const BuiltTripleZ& built,
                   bool is_physics,
                   std::uint64_t seed,
                   std::uint64_t sample);

  Outcome Run(const Segment& segment, const Watch& watch) override;
  void Settle(const Motors& steps) override { steps_ = steps; }
  void Dwell(double /*s*/) override {}
  bool ProbeTriggered() override;
  bool SwitchClosed(Axis axis) override;

  bool Acts(const PinSensor& sensor, const Motors& steps) override;
  void Follow(const Motors& steps) override { steps_ = steps; }
  void Arm(const PinSensor& sensor) override;

  const BuiltTripleZ& built() const { return built_; }
  /// Clear height of the nozzle over the bed beneath it, by the closed forms.
  double NozzleOverBed_mm(const Motors& steps) const;

 private:
  /// Where the motors have head and screws, by the steps/mm of the machine's settings.
  struct Stand {
    Eigen::Vector2d head_mm = Eigen::Vector2d::Zero();
    Vec3<double> screws_mm = Vec3<double>::Zero();  ///< Over their lower ends.
    double nozzle_mm = 0;  ///< Over the bed beneath it, as drawn.
    /// Each screw beyond what that height alone has it.
    Vec3<double> raised_mm = Vec3<double>::Zero();
  };
  Stand StandAt(const Motors& steps) const;
  /// How far the carriage of x or y is from its home end; positive before.
  double BeforeHome_mm(Axis axis, const Stand& stand) const;
  /// Height of the nozzle over the bed at the trigger, as drawn, and its scatter.
  struct Trigger {
    double height_mm = 0, scatter_mm = 0;
  };
  /// nullopt: none.
  std::optional<Trigger> TriggerAt(const Stand& stand, double feed_mm_s);
  bool ProbeActs(const Stand& stand);
  Outcome RunToProbe(const Segment& segment, bool is_release);
  Outcome RunToSwitch(const Segment& segment, Axis axis) const;

  BuiltTripleZ built_;
  std::unique_ptr<TripleZMachine> machine_{};
  Rng scatter_;
  Motors steps_;
  bool is_triggered_ = false;
  double chance_ = 0;  ///< Of the probe now armed, in standard deviations.
};

/// What a printer's firmware starts with beside its settings, believing the screws to
/// stand there.
FirmwareOptions FirmwareOnScrews(const Pivots<double>& believed_mm);

/// Where the bed is truly touched over (x, y) with the screws raised so, noise apart:
/// what the closed forms say.
double TrueBedHeight_mm(const BuiltTripleZ& built,
                        const Vec3<double>& raised_mm,
                        const Eigen::Vector2d& at_mm);

}  // namespace caltwin

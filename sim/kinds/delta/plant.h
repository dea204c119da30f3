#pragma once

#include <memory>
#include <vector>

#include "sim/base/rng.h"
#include "sim/effects/effect.h"
#include "sim/firmware/plant.h"
#include "sim/kinds/delta/world.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/kinds/delta/play.h"
#include "sim/machine/kinds/delta/touch.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// A delta as it is built: what its firmware cannot know.
struct BuiltDelta {
  DeltaBuild<double> build{};
  DeltaBed<double> bed{};
  double scatter_mm = 0;  ///< Of the trigger, along z.
  DeltaTip tip{};
  CarriageGaps_mm play_mm{};
};

/// Moves what `effects` say of play (carriage_backlash) into `built`.
void BuildPlayIn(std::vector<Injected>* effects, BuiltDelta* built);

/// A simulated delta: closed form or MuJoCo. Its motors are the towers', in steps of
/// travel down from the endstops. Between touches it is where its motors are.
class DeltaTwinPlant final : public Plant {
 public:
  /// @param is_physics  MuJoCo finds the trigger
  DeltaTwinPlant(const Machine& machine,
                 const BuiltDelta& built,
                 bool is_physics,
                 std::uint64_t seed,
                 std::uint64_t sample);

  /// The probe is watched for on a way down, with the whole descent as the segment's
  /// curve.
  Outcome Run(const Segment& segment, const Watch& watch) override;
  void Settle(const Motors& steps) override { steps_ = steps; }
  void Dwell(double /*s*/) override {}
  bool ProbeTriggered() override { return is_triggered_; }
  /// Of the tower of that index.
  bool SwitchClosed(Axis axis) override { return steps_[Index(axis)] <= 0; }

  const BuiltDelta& built() const { return built_; }

 private:
  Outcome RunToProbe(const Segment& segment);

  Machine machine_;
  BuiltDelta built_;
  std::array<double, 3> steps_per_mm_{};
  std::unique_ptr<DeltaWorld> world_{};
  Rng scatter_;
  Motors steps_ = Motors::Zero(3);
  bool is_triggered_ = false;
  /// How far down the last touch was: where the next is looked for.
  std::optional<double> found_mm_{};
};

/// The height that its firmware believes the nozzle of a delta built so at when it
/// touches the bed on that descent: found by MuJoCo in `world`, or, without one, in
/// closed form, which throws InputError where a sprung probe triggers while a loose
/// carriage crosses its gap (sprung_probe.h). `near_mm`: where it is searched for.
/// nullopt: out of reach.
std::optional<double> TouchOfDelta_mm(DeltaWorld* world,
                                      const Machine& machine,
                                      const BuiltDelta& built,
                                      const DeltaDescent& descent,
                                      double near_mm);

/// The same straight down at (x, y) by these settings.
std::optional<double> TouchOfDelta_mm(DeltaWorld* world,
                                      const Machine& machine,
                                      const BuiltDelta& built,
                                      const DeltaModel<double>& settings,
                                      const Eigen::Vector2d& at_mm);

/// Where its nozzle rests, in closed form, every motor having come to its commanded
/// travel in its sense (+1: down, -1: up). nullopt: out of reach.
std::optional<Vec3<double>> NozzleOfDelta(const Machine& machine,
                                          const BuiltDelta& built,
                                          const Vec3<double>& motors_mm,
                                          const Vec3<double>& motor_dir);

/// MuJoCo's world of a delta as it is built, with what it touches with.
DeltaWorld WorldOfDelta(const Machine& machine, const BuiltDelta& built);

/// The model that a delta's machine file names, or the one that every delta can be.
DeltaMjcf ModelOfDelta(const Machine& machine);

}  // namespace caltwin

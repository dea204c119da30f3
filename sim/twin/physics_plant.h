#pragma once

#include <memory>
#include <optional>

#include "sim/twin/built_world.h"
#include "sim/twin/twin_plant.h"

namespace caltwin {

/// The machine in MuJoCo. Contact decides the trigger: a sprung stylus is pushed by the
/// surface until its deflection opens the switch; the time of that is interpolated
/// within one step (0.2 ms).
///
/// Free space is jumped: far from any surface the machine is put ahead along its path,
/// gaps and sense carried across by the play operator as the full run would leave them,
/// and stepping begins 40 steps, at least 10 um, before contact. Distances for this
/// come from MuJoCo's geometry, not from the closed form.
class PhysicsPlant final : public TwinPlant {
 public:
  PhysicsPlant(Built built, std::uint64_t seed, std::uint64_t sample);

  Outcome Run(const Segment& segment, const Watch& watch) override;
  void Settle(const Motors& steps) override;
  void Dwell(double s) override;
  bool ProbeTriggered() override;
  bool SwitchClosed(Axis axis) override;
  void Change(const std::vector<Artefact>& artefacts, Stylus stylus) override;
  Vec3<double> Tip_mm() override;

  World& world() { return *world_; }
  /// Steps taken so far, for benchmarks.
  std::int64_t num_steps() const { return num_steps_; }
  /// Whether free space is jumped (the default) or stepped through.
  void set_jumps(bool jumps) { jumps_ = jumps; }

 private:
  struct Watched;
  void Rebuild();
  Outcome Perform(const Segment& segment, const Watch& watch);
  bool MayJump(const Segment& segment) const;
  double FreePath_mm(const Watch& watch) const;
  void PlaceAt(const Segment& segment, double t_s);
  double Jump(const Segment& segment, const Watch& watch, double t_s);
  /// Carriage minus motor of each drive.
  Vec3<double> Lag_mm() const;
  double TriggerSignal_mm() const;
  double Signal_mm(const Watch& watch) const;
  void StepTo(const Vec3<double>& steps);
  Outcome Stopped(const Segment& segment, const Watch& watch, double t_s, double at_s);

  Mjcf drawn_;  ///< The model with the drawing applied, before effects and artefacts.
  std::unique_ptr<BuiltWorld> world_;
  bool triggered_ = false;
  bool jumps_ = true;
  std::int64_t num_steps_ = 0;
};

}  // namespace caltwin

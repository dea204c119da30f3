#pragma once

#include <memory>
#include <vector>

#include "sim/base/rng.h"
#include "sim/effects/effect.h"
#include "sim/firmware/dialects/marlin_delta.h"
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

/// A simulated delta that can be touched: closed form or MuJoCo. What it answers is a
/// count of whole motor steps, as a controller has it.
class DeltaTwinPlant : public DeltaPlant {
 public:
  /// @param is_physics  MuJoCo finds the trigger
  DeltaTwinPlant(const Machine& machine,
                 const BuiltDelta& built,
                 bool is_physics,
                 std::uint64_t seed,
                 std::uint64_t sample);

  std::optional<Vec3<double>> Touch(const DeltaModel<double>& settings,
                                    double x_mm,
                                    double y_mm) override;

  const BuiltDelta& built() const { return built_; }

 private:
  Machine machine_;
  BuiltDelta built_;
  std::array<double, 3> steps_per_mm_{};
  std::unique_ptr<DeltaWorld> world_{};
  Rng scatter_;
};

/// Where a delta built so touches its bed on the way straight down at (x, y) by these
/// settings: found by MuJoCo in `world`, or, without one, in closed form, which
/// throws InputError where a sprung probe triggers while a loose carriage crosses its
/// gap (sprung_probe.h). The motors' commanded travels; nullopt: out of reach.
std::optional<Vec3<double>> TouchOfDelta(DeltaWorld* world,
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

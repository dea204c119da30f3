#include "sim/kinds/delta/plant.h"

#include <algorithm>
#include <cmath>

#include "sim/base/require.h"
#include "sim/effects/catalog.h"
#include "sim/effects/drive.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/kinds/delta/sprung_probe.h"

namespace caltwin {

DeltaMjcf ModelOfDelta(const Machine& machine) {
  return DeltaMjcf::FromFile(machine.model.empty()
                                 ? ShareFolder() / "models/delta_printer/model.xml"
                                 : machine.model);
}

DeltaWorld WorldOfDelta(const Machine& machine, const BuiltDelta& built) {
  DeltaMjcf model = ModelOfDelta(machine);
  if (built.tip.pretravel_mm > 0) {
    model.AddProbe(built.tip.off_mm);
  } else {
    model.MoveNozzle(built.tip.off_mm);
  }
  model.SetBuild(built.build);
  if (const auto* delta = machine.Own<DeltaDrawing>()) {
    model.SetEffectorMass_kg(delta->effector_mass_kg);
  }
  for (int i = 0; i < kNumTowers; ++i) {
    const auto tower = static_cast<std::size_t>(i);
    if (built.play_mm[tower] <= 0) continue;
    model.AddPlay({.tower = i,
                   .gap_mm = built.play_mm[tower],
                   .friction_n = machine.axes[tower].rail_friction_n,
                   .carriage_kg = machine.axes[tower].moving_mass_kg});
  }
  constexpr double kWithPlay_s = 0.0002;  // Flanks are met to 0.01 um.
  const bool has_play = HasPlay(built.play_mm);
  model.SetTimestep_s(has_play ? kWithPlay_s : TouchTimestep_s(built.tip));
  model.SetBed(built.bed);
  return {model.Compile(/*with_looks=*/false), built.build};
}

void BuildPlayIn(std::vector<Injected>* effects, BuiltDelta* built) {
  std::erase_if(*effects, [&](const Injected& effect) {
    if (effect.effect != EffectIndex<CarriageBacklash>()) return false;
    const auto tower = static_cast<std::size_t>(DriveNamed(effect.axis)->index);
    built->play_mm[tower] += effect.values[0];
    return true;
  });
}

std::optional<Vec3<double>> NozzleOfDelta(const Machine& machine,
                                          const BuiltDelta& built,
                                          const Vec3<double>& motors_mm,
                                          const Vec3<double>& motor_dir) {
  const auto taken =
      WithPlayTaken(built.build, machine, built.play_mm, motors_mm, motor_dir);
  if (!taken) return std::nullopt;
  const auto pose = DeltaPoseOf(*taken, motors_mm);
  if (!pose) return std::nullopt;
  return pose->nozzle_mm;
}

std::optional<Vec3<double>> TouchOfDelta(DeltaWorld* world,
                                         const Machine& machine,
                                         const BuiltDelta& built,
                                         const DeltaModel<double>& settings,
                                         const Eigen::Vector2d& at_mm) {
  if (world != nullptr) {
    return TouchInPhysics(
        world, built.build, built.bed, settings, at_mm, {.tip = built.tip});
  }
  const auto touched = [&](const DeltaBuild<double>& build) {
    return DeltaTouchMotors(build, built.bed, settings, at_mm[0], at_mm[1], built.tip);
  };
  const auto motors_mm = touched(built.build);
  if (!motors_mm || !HasPlay(built.play_mm)) return motors_mm;
  // Straight down go all carriages.
  const auto taken =
      built.tip.pretravel_mm > 0
          ? WithPlayTakenByProbe(
                built.build, machine, built.play_mm, *motors_mm, built.tip.pretravel_mm)
          : WithPlayTaken(
                built.build, machine, built.play_mm, *motors_mm, Vec3<double>::Ones());
  return taken ? touched(*taken) : std::nullopt;
}

DeltaTwinPlant::DeltaTwinPlant(const Machine& machine,
                               const BuiltDelta& built,
                               bool is_physics,
                               std::uint64_t seed,
                               std::uint64_t sample)
    : machine_(machine),
      built_(built),
      steps_per_mm_(TowerStepsPerMm(machine)),
      scatter_(seed, sample, "trigger_scatter") {
  Require(machine.Own<DeltaDrawing>() != nullptr, "the machine is a delta");
  if (is_physics) {
    world_ = std::make_unique<DeltaWorld>(WorldOfDelta(machine, built));
  }
}

std::optional<Vec3<double>> DeltaTwinPlant::Touch(const DeltaModel<double>& settings,
                                                  double x_mm,
                                                  double y_mm) {
  const auto motors_mm =
      TouchOfDelta(world_.get(), machine_, built_, settings, {x_mm, y_mm});
  if (!motors_mm) return std::nullopt;
  Vec3<double> at = DeltaNozzle_mm(settings, *motors_mm);
  if (built_.scatter_mm > 0) at[2] += built_.scatter_mm * scatter_.Normal();
  Vec3<double> counted_mm = DeltaMotors_mm(settings, at);
  for (int i = 0; i < 3; ++i) {
    const double steps_per_mm = steps_per_mm_[static_cast<std::size_t>(i)];
    counted_mm[i] = std::round(counted_mm[i] * steps_per_mm) / steps_per_mm;
  }
  return counted_mm;
}

}  // namespace caltwin

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
    const auto tower = TowerNamed(effect.axis);
    if (effect.effect != EffectIndex<CarriageBacklash>() || !tower) return false;
    built->play_mm[static_cast<std::size_t>(*tower)] += effect.values[0];
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

std::optional<double> TouchOfDelta_mm(DeltaWorld* world,
                                      const Machine& machine,
                                      const BuiltDelta& built,
                                      const DeltaDescent& descent,
                                      double near_mm) {
  if (world != nullptr) {
    return TouchInPhysics_mm(
        world, built.build, built.bed, descent, near_mm, {.tip = built.tip});
  }
  const auto touched_mm = [&](const DeltaBuild<double>& build) {
    return DeltaTouchHeight_mm(build, built.bed, descent, near_mm, built.tip);
  };
  const auto z_mm = touched_mm(built.build);
  if (!z_mm || !HasPlay(built.play_mm)) return z_mm;
  const Vec3<double> motors_mm = descent(*z_mm);
  // Straight down go all carriages.
  const auto taken =
      built.tip.pretravel_mm > 0
          ? WithPlayTakenByProbe(
                built.build, machine, built.play_mm, motors_mm, built.tip.pretravel_mm)
          : WithPlayTaken(
                built.build, machine, built.play_mm, motors_mm, Vec3<double>::Ones());
  return taken ? touched_mm(*taken) : std::nullopt;
}

std::optional<double> TouchOfDelta_mm(DeltaWorld* world,
                                      const Machine& machine,
                                      const BuiltDelta& built,
                                      const DeltaModel<double>& settings,
                                      const Eigen::Vector2d& at_mm) {
  const auto descent = [&](double z_mm) {
    return DeltaMotors_mm<double>(settings, {at_mm[0], at_mm[1], z_mm});
  };
  return TouchOfDelta_mm(
      world, machine, built, descent, built.bed.Height_mm(at_mm[0], at_mm[1]));
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

Outcome DeltaTwinPlant::RunToProbe(const Segment& segment) {
  const Profile& profile = segment.profile;
  const DeltaDescent descent = [&](double z_mm) {
    const Motors steps =
        segment.curve
            ? segment.curve(-z_mm)
            : Motors(segment.from_steps - z_mm / profile.length_mm *
                                              (segment.to_steps - segment.from_steps));
    Vec3<double> motors_mm;
    for (int i = 0; i < kNumTowers; ++i) {
      motors_mm[i] = steps[i] / steps_per_mm_[static_cast<std::size_t>(i)];
    }
    return motors_mm;
  };
  const auto z_mm = TouchOfDelta_mm(
      world_.get(), machine_, built_, descent, -found_mm_.value_or(profile.length_mm));
  if (!z_mm) return {.time_s = profile.Duration_s()};
  double gone_mm = -*z_mm;
  found_mm_ = gone_mm;
  if (built_.scatter_mm > 0) gone_mm -= built_.scatter_mm * scatter_.Normal();
  if (gone_mm > profile.length_mm) return {.time_s = profile.Duration_s()};
  return {.stopped = true, .time_s = profile.Time_s(std::max(gone_mm, 0.0))};
}

Outcome DeltaTwinPlant::Run(const Segment& segment, const Watch& watch) {
  Outcome outcome{.time_s = segment.profile.Duration_s()};
  is_triggered_ = false;
  if (watch.kind == Watch::Kind::kProbeTriggered) {
    outcome = RunToProbe(segment);
    is_triggered_ = outcome.stopped;
  } else if (watch.kind == Watch::Kind::kSwitchClosed) {
    // Each carriage stops at its own endstop.
    outcome.stopped = (segment.to_steps.array() <= 0).all();
    if (outcome.stopped) outcome.stand_steps = Motors::Zero(kNumTowers);
  }
  steps_ = outcome.stand_steps.value_or(segment.Steps(outcome.time_s));
  return outcome;
}

}  // namespace caltwin

#include "sim/kinds/delta/world.h"

#include <algorithm>
#include <cmath>

#include "sim/base/require.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {
namespace {

constexpr double kMmPerM = 1e3;

int IdOf(const mjModel* model, mjtObj type, const std::string& name) {
  const int id = mj_name2id(model, type, name.c_str());
  Require(id >= 0, "the model has every name that DeltaMjcf checked");
  return id;
}

}  // namespace

DeltaWorld::DeltaWorld(ModelPtr model, const DeltaBuild<double>& build)
    : model_(std::move(model)), data_(mj_makeData(model_.get())) {
  for (int i = 0; i < kNumTowers; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const int carriage = IdOf(model_.get(), mjOBJ_JOINT, TowerName(i));
    const int drive =
        mj_name2id(model_.get(), mjOBJ_JOINT, ("drive_" + TowerName(i)).c_str());
    const int joint = drive < 0 ? carriage : drive;
    qpos_[at] = model_->jnt_qposadr[joint];
    dof_[at] = model_->jnt_dofadr[joint];
    carriage_qpos_[at] = model_->jnt_qposadr[carriage];
    carriage_dof_[at] = model_->jnt_dofadr[carriage];
    mass_kg_[at] =
        model_->dof_armature[dof_[at]] + model_->body_mass[model_->jnt_bodyid[joint]];
    scale_[i] = 1 + build.belt_scale[at];
  }
  const int free = IdOf(model_.get(), mjOBJ_JOINT, "effector");
  effector_qpos_ = model_->jnt_qposadr[free];
  effector_dof_ = model_->jnt_dofadr[free];
  effector_body_ = IdOf(model_.get(), mjOBJ_BODY, "effector");
  const int probe = mj_name2id(model_.get(), mjOBJ_JOINT, "probe");
  if (probe >= 0) probe_qpos_ = model_->jnt_qposadr[probe];
  for (int k = 0; k < kNumRods; ++k) {
    const auto rod = static_cast<std::size_t>(k);
    const int tendon = IdOf(model_.get(), mjOBJ_TENDON, "rod_" + RodName(k));
    const int equality = IdOf(model_.get(), mjOBJ_EQUALITY, "rod_" + RodName(k));
    const double length_mm = build.model.arm_mm[rod / 2] + build.rod_error_mm[rod];
    model_->eq_data[mjNEQDATA * equality] =
        length_mm * kMPerMm - model_->tendon_length0[tendon];
  }
}

void DeltaWorld::Place(const Vec3<double>& motors_mm,
                       const DeltaPose<double>& pose,
                       const Vec3<double>& motors_mm_s,
                       const Vec3<double>& nozzle_mm_s) {
  mj_resetData(model_.get(), data_.get());
  for (int i = 0; i < kNumTowers; ++i) {
    const auto at = static_cast<std::size_t>(i);
    data_->qpos[qpos_[at]] = -motors_mm[i] * scale_[i] * kMPerMm;
    data_->qvel[dof_[at]] = -motors_mm_s[i] * scale_[i] * kMPerMm;
    data_->qpos[carriage_qpos_[at]] = data_->qpos[qpos_[at]];
    data_->qvel[carriage_dof_[at]] = data_->qvel[dof_[at]];
  }
  const double norm = std::sqrt(1 + pose.cayley.squaredNorm());
  for (int i = 0; i < 3; ++i) {
    data_->qpos[effector_qpos_ + i] = pose.nozzle_mm[i] * kMPerMm;
    data_->qpos[effector_qpos_ + 4 + i] = pose.cayley[i] / norm;
    data_->qvel[effector_dof_ + i] = nozzle_mm_s[i] * kMPerMm;
  }
  data_->qpos[effector_qpos_ + 3] = 1 / norm;
}

void DeltaWorld::Step(const Vec3<double>& motors_mm) {
  const double dt = timestep_s();
  for (int i = 0; i < kNumTowers; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const double to_m = -motors_mm[i] * scale_[i] * kMPerMm;
    data_->qfrc_applied[dof_[at]] =
        mass_kg_[at] * (to_m - data_->qpos[qpos_[at]] - dt * data_->qvel[dof_[at]]) /
        (dt * dt);
  }
  mj_step(model_.get(), data_.get());
  for (const mjWarningStat& warning : data_->warning) {
    Require(warning.number == 0, "MuJoCo warns: the simulation is not to be trusted");
  }
}

std::optional<double> DeltaWorld::Clearance_mm() const {
  std::optional<double> least_mm;
  for (int i = 0; i < data_->ncon; ++i) {
    const double dist_mm = data_->contact[i].dist * kMmPerM;
    if (!least_mm || dist_mm < *least_mm) least_mm = dist_mm;
  }
  return least_mm;
}

std::optional<double> DeltaWorld::Deflection_mm() const {
  if (probe_qpos_ < 0) return std::nullopt;
  return data_->qpos[probe_qpos_] * kMmPerM;
}

Vec3<double> DeltaWorld::Nozzle_mm() const {
  Vec3<double> at;
  for (int i = 0; i < 3; ++i) at[i] = data_->qpos[effector_qpos_ + i] * kMmPerM;
  return at;
}

double DeltaWorld::MostPlay_mm() const {
  double most_m = 0;
  for (int tendon = 0; tendon < model_->ntendon; ++tendon) {
    if (model_->tendon_limited[tendon] == 0) continue;
    const mjtNum* range_m = model_->tendon_range + 2 * tendon;
    most_m = std::max(most_m, range_m[1] - range_m[0]);
  }
  return most_m * kMmPerM;
}

Vec3<double> DeltaWorld::Motors_mm() const {
  Vec3<double> at;
  for (int i = 0; i < kNumTowers; ++i) {
    at[i] = -data_->qpos[qpos_[static_cast<std::size_t>(i)]] * kMmPerM / scale_[i];
  }
  return at;
}

double TouchTimestep_s(const DeltaTip& tip) {
  constexpr double kNozzle_s = 0.001, kLong_s = 0.0005, kShort_s = 0.0002;
  constexpr double kLong_mm = 0.2;
  if (tip.pretravel_mm == 0) return kNozzle_s;
  return tip.pretravel_mm < kLong_mm ? kShort_s : kLong_s;
}

std::optional<Vec3<double>> RestInPhysics(DeltaWorld* world,
                                          const DeltaBuild<double>& build,
                                          const Vec3<double>& motors_mm,
                                          const Vec3<double>& motor_dir) {
  constexpr double kFeed_mm_s = 5, kBeyondPlay_mm = 0.1;
  // At the full feed a carriage with play would coast a micrometre beyond the stop.
  constexpr double kSlow_mm_s = 0.5, kSlowFor_mm = 0.02;
  constexpr int kRestSteps = 3, kRestStepsWithPlay = 30;
  const double play_mm = world->MostPlay_mm();
  const double way_mm = play_mm > 0 ? play_mm + kBeyondPlay_mm : 0;
  const auto motors_at = [&](double left_mm) -> Vec3<double> {
    return motors_mm - left_mm * motor_dir;
  };
  const auto pose = DeltaPoseOf(build, motors_at(way_mm));
  if (!pose) return std::nullopt;
  world->Place(motors_at(way_mm), *pose, Vec3<double>::Zero(), Vec3<double>::Zero());
  for (double left_mm = way_mm; left_mm > 0;) {
    const double feed_mm_s = left_mm > kSlowFor_mm ? kFeed_mm_s : kSlow_mm_s;
    left_mm = std::max(left_mm - feed_mm_s * world->timestep_s(), 0.0);
    world->Step(motors_at(left_mm));
  }
  for (int i = 0; i < (play_mm > 0 ? kRestStepsWithPlay : kRestSteps); ++i) {
    world->Step(motors_mm);
  }
  return world->Nozzle_mm();
}

std::optional<double> TouchInPhysics_mm(DeltaWorld* world,
                                        const DeltaBuild<double>& build,
                                        const DeltaBed<double>& bed,
                                        const DeltaDescent& descent,
                                        double near_mm,
                                        const DeltaTouchOptions& options) {
  const DeltaTip& tip = options.tip;
  const bool is_sprung = world->Deflection_mm().has_value();
  Require(is_sprung == (tip.pretravel_mm > 0), "the model has the tip that touches");
  const auto expected_mm = DeltaTouchHeight_mm(build, bed, descent, near_mm, tip);
  if (!expected_mm) return std::nullopt;
  const double step_mm = options.feed_mm_s * world->timestep_s();
  // Carriages with play are to have crossed it before the contact: the nozzle comes
  // down by less than half of what one carriage does alone, by as much as all do.
  const double start_mm =
      options.start_mm + tip.pretravel_mm + 3 * world->MostPlay_mm();
  const auto motors_at = [&](double above_mm) {
    return descent(*expected_mm + above_mm);
  };
  const auto pose = DeltaPoseOf(build, motors_at(start_mm));
  if (!pose) return std::nullopt;
  const Vec3<double> speed =
      (motors_at(start_mm - step_mm) - motors_at(start_mm)) / world->timestep_s();
  world->Place(motors_at(start_mm), *pose, speed, -options.feed_mm_s * Unit(Axis::kZ));
  std::optional<double> before_mm;
  double above_mm = start_mm;
  while (above_mm > -options.most_mm) {
    world->Step(motors_at(above_mm - step_mm));
    // A contact is found where the step began; a deflection is that of its end.
    const auto left_mm =
        is_sprung ? tip.pretravel_mm - *world->Deflection_mm() : world->Clearance_mm();
    const double read_at_mm = is_sprung ? above_mm - step_mm : above_mm;
    if (left_mm && *left_mm <= 0) {
      if (!before_mm) return std::nullopt;
      const double part = *before_mm / (*before_mm - *left_mm);
      return *expected_mm + read_at_mm + step_mm * (1 - part);
    }
    before_mm = left_mm;
    above_mm -= step_mm;
  }
  return std::nullopt;
}

}  // namespace caltwin

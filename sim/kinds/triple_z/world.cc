#include "sim/kinds/triple_z/world.h"

#include <algorithm>
#include <string>

#include <Eigen/Geometry>

#include "sim/base/require.h"
#include "sim/machine/kinds/triple_z/drawing.h"

namespace caltwin {
namespace {

constexpr double kMmPerM = 1e3;

int IdOf(const mjModel* model, mjtObj type, const std::string& name) {
  const int id = mj_name2id(model, type, name.c_str());
  Require(id >= 0, "the model has every name that TripleZMjcf checked");
  return id;
}

int QposOf(const mjModel* model, const std::string& joint) {
  return model->jnt_qposadr[IdOf(model, mjOBJ_JOINT, joint)];
}

Vec3<double> Flat(const Eigen::Vector2d& at_mm) {
  return {at_mm[0], at_mm[1], 0};
}

// The rotation that takes the bed's groove and normal to where the balls have them.
Eigen::Matrix3d BedRotation(const Vec3<double>& groove,
                            const Vec3<double>& groove_now,
                            const Vec3<double>& normal_now) {
  Eigen::Matrix3d drawn, now;
  drawn << groove, Vec3<double>::UnitZ().cross(groove), Vec3<double>::UnitZ();
  now << groove_now, normal_now.cross(groove_now), normal_now;
  return now * drawn.transpose();
}

}  // namespace

TripleZWorld::TripleZWorld(ModelPtr model,
                           const Pivots<double>& pivots_mm,
                           double held_mm2)
    : model_(std::move(model)),
      data_(mj_makeData(model_.get())),
      pivots_mm_(pivots_mm),
      held_n_m_(held_mm2 * kMPerMm * kMPerMm * kScrew_n_per_m) {
  for (int i = 0; i < kNumScrews; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const int joint = IdOf(model_.get(), mjOBJ_JOINT, ScrewName(i));
    qpos_[at] = model_->jnt_qposadr[joint];
    dof_[at] = model_->jnt_dofadr[joint];
    mass_kg_[at] =
        model_->dof_armature[dof_[at]] + model_->body_mass[model_->jnt_bodyid[joint]];
  }
  const int free = IdOf(model_.get(), mjOBJ_JOINT, "bed");
  bed_qpos_ = model_->jnt_qposadr[free];
  bed_dof_ = model_->jnt_dofadr[free];
  bed_body_ = IdOf(model_.get(), mjOBJ_BODY, "bed");
  groove_qpos_ = QposOf(model_.get(), "groove");
  flat_x_qpos_ = QposOf(model_.get(), "flat_x");
  flat_y_qpos_ = QposOf(model_.get(), "flat_y");
  spot_geom_ = IdOf(model_.get(), mjOBJ_GEOM, "spot");
  head_mocap_ = model_->body_mocapid[IdOf(model_.get(), mjOBJ_BODY, "head")];
  Require(head_mocap_ >= 0, "the head is a mocap body");
}

void TripleZWorld::HangNozzle(const Vec3<double>& tip_mm) {
  for (int i = 0; i < 3; ++i) {
    data_->mocap_pos[3 * head_mocap_ + i] = tip_mm[i] * kMPerMm;
  }
}

void TripleZWorld::SetSpot(const BedSpot& spot) {
  const Vec3<double> normal =
      Vec3<double>(-spot.slope_x, -spot.slope_y, 1).normalized();
  const double half_m = model_->geom_size[3 * spot_geom_ + 2];
  for (int i = 0; i < 3; ++i) {
    const double top_mm = i == 2 ? spot.height_mm : spot.at_mm[i];
    model_->geom_pos[3 * spot_geom_ + i] = top_mm * kMPerMm - half_m * normal[i];
  }
  const auto turn =
      Eigen::Quaterniond::FromTwoVectors(Vec3<double>::UnitZ(), normal).normalized();
  mjtNum* quat = model_->geom_quat + 4 * spot_geom_;
  quat[0] = turn.w();
  for (int i = 0; i < 3; ++i) quat[i + 1] = turn.vec()[i];
  // What MuJoCo takes for a body-aligned geom must not be taken so any more.
  model_->geom_sameframe[spot_geom_] = mjSAMEFRAME_NONE;
}

void TripleZWorld::Place(const Vec3<double>& heights_mm, double speed_mm_s) {
  const Vec3<double> hung_m(data_->mocap_pos[3 * head_mocap_],
                            data_->mocap_pos[3 * head_mocap_ + 1],
                            data_->mocap_pos[3 * head_mocap_ + 2]);
  mj_resetData(model_.get(), data_.get());
  HangNozzle(hung_m * kMmPerM);
  told_mm_ = heights_mm;
  std::array<Vec3<double>, kNumScrews> ball_mm, drawn_mm;
  for (std::size_t i = 0; i < ball_mm.size(); ++i) {
    drawn_mm[i] = Flat(pivots_mm_[i]);
    const double height_mm = heights_mm[static_cast<Eigen::Index>(i)];
    ball_mm[i] = drawn_mm[i] + height_mm * Vec3<double>::UnitZ();
    data_->qpos[qpos_[i]] = height_mm * kMPerMm;
    data_->qvel[dof_[i]] = speed_mm_s * kMPerMm;
  }
  const Vec3<double> groove = (drawn_mm[1] - drawn_mm[0]).normalized();
  const Vec3<double> groove_mm = ball_mm[1] - ball_mm[0];
  Vec3<double> normal = groove_mm.cross(ball_mm[2] - ball_mm[0]).normalized();
  if (normal[2] < 0) normal = -normal;
  const Eigen::Matrix3d turn = BedRotation(groove, groove_mm.normalized(), normal);
  const Vec3<double> bed_mm = ball_mm[0] - turn * drawn_mm[0];
  const Eigen::Quaterniond quat(turn);
  for (int i = 0; i < 3; ++i) {
    data_->qpos[bed_qpos_ + i] = bed_mm[i] * kMPerMm;
    data_->qpos[bed_qpos_ + 4 + i] = quat.vec()[i];
  }
  data_->qpos[bed_qpos_ + 3] = quat.w();
  data_->qvel[bed_dof_ + 2] = speed_mm_s * kMPerMm;
  const Vec3<double> flat_mm = turn.transpose() * (ball_mm[2] - bed_mm) - drawn_mm[2];
  data_->qpos[groove_qpos_] =
      (groove_mm.norm() - (drawn_mm[1] - drawn_mm[0]).norm()) * kMPerMm;
  data_->qpos[flat_x_qpos_] = flat_mm[0] * kMPerMm;
  data_->qpos[flat_y_qpos_] = flat_mm[1] * kMPerMm;
}

void TripleZWorld::DriveNuts(const Vec3<double>& heights_mm) {
  const double dt = timestep_s();
  for (std::size_t i = 0; i < qpos_.size(); ++i) {
    const double to_m = heights_mm[static_cast<Eigen::Index>(i)] * kMPerMm;
    data_->qfrc_applied[dof_[i]] =
        mass_kg_[i] * (to_m - data_->qpos[qpos_[i]] - dt * data_->qvel[dof_[i]]) /
        (dt * dt);
  }
}

// Springs to where the screws stand as the step begins; the joints' damping is of the
// nuts' speed, so that of the screws is given back.
void TripleZWorld::PushNuts(const Vec3<double>& heights_mm) {
  for (std::size_t i = 0; i < qpos_.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    const double from_m = told_mm_[at] * kMPerMm;
    const double speed_m_s = (heights_mm[at] * kMPerMm - from_m) / timestep_s();
    data_->qfrc_applied[dof_[i]] = kScrew_n_per_m * (from_m - data_->qpos[qpos_[i]]) +
                                   kNutDamping_n_s_per_m * speed_m_s;
  }
}

void TripleZWorld::TurnBedBack() {
  const mjtNum* q = data_->qpos + bed_qpos_;
  const Vec3<double> normal =
      Eigen::Quaterniond(q[3], q[4], q[5], q[6]).normalized() * Vec3<double>::UnitZ();
  mjtNum* moment_n_m = data_->xfrc_applied + 6 * bed_body_ + 3;
  moment_n_m[0] = held_n_m_ * normal[1] / normal[2];
  moment_n_m[1] = -held_n_m_ * normal[0] / normal[2];
}

void TripleZWorld::Step(const Vec3<double>& heights_mm) {
  if (held_n_m_ > 0) {
    PushNuts(heights_mm);
    TurnBedBack();
  } else {
    DriveNuts(heights_mm);
  }
  told_mm_ = heights_mm;
  mj_step(model_.get(), data_.get());
  for (const mjWarningStat& warning : data_->warning) {
    Require(warning.number == 0, "MuJoCo warns: the simulation is not to be trusted");
  }
}

std::optional<double> TripleZWorld::Clearance_mm() const {
  std::optional<double> least_mm;
  for (int i = 0; i < data_->ncon; ++i) {
    const double dist_mm = data_->contact[i].dist * kMmPerM;
    if (!least_mm || dist_mm < *least_mm) least_mm = dist_mm;
  }
  return least_mm;
}

double TripleZWorld::Plane_mm(const Eigen::Vector2d& at_mm) const {
  const mjtNum* q = data_->qpos + bed_qpos_;
  const Vec3<double> normal =
      Eigen::Quaterniond(q[3], q[4], q[5], q[6]).normalized() * Vec3<double>::UnitZ();
  const Eigen::Vector2d from_mm(q[0] * kMmPerM, q[1] * kMmPerM);
  return q[2] * kMmPerM - normal.head<2>().dot(at_mm - from_mm) / normal[2];
}

}  // namespace caltwin

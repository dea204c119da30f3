#include "sim/physics/world.h"

#include <algorithm>
#include <mutex>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "sim/base/require.h"

namespace caltwin {
namespace {

constexpr double kMmPerM = 1e3;
// A play whose length depends on joints that follow the carriage settles by a factor of
// 1000 or so each time.
constexpr int kSettlings = 3;

int IdOf(const mjModel* model, mjtObj type, const std::string& name) {
  const int id = mj_name2id(model, type, name.c_str());
  Require(id >= 0, fmt::format("the model has no '{}'", name));
  return id;
}

// MuJoCo writes its warnings to a file in the working folder otherwise; Step looks at
// their counts instead.
void SilenceLog() {
  static std::once_flag once;
  std::call_once(once, [] { mju_setLogHandler([](const mjLogMessage*) {}); });
}

}  // namespace

World::World(ModelPtr model, double hanging_n)
    : model_(std::move(model)), hanging_n_(hanging_n) {
  SilenceLog();
  data_.reset(mj_makeData(model_.get()));
  nuts_ = SlotsOf("", "_nut");
  carriages_ = SlotsOf("", "");
  stylus_ = SlotsOf("stylus_", "");
  const mjModel* m = model_.get();
  z_body_ = IdOf(m, mjOBJ_BODY, "z_carriage");
  table_body_ = IdOf(m, mjOBJ_BODY, "table");
  stylus_body_ = IdOf(m, mjOBJ_BODY, "stylus");
  std::copy_n(m->body_pos + 3 * stylus_body_, 3, stylus_pos_.begin());
  std::copy_n(m->body_pos + 3 * table_body_, 3, table_pos_.begin());
  std::copy_n(m->body_quat + 4 * table_body_, 4, table_quat_.begin());
  for (int geom = 0; geom < m->ngeom; ++geom) {
    if (m->geom_bodyid[geom] == table_body_ && m->geom_contype[geom] == kTouchable) {
      touchable_.push_back(geom);
    }
    if (m->geom_bodyid[geom] == stylus_body_ && m->geom_contype[geom] == kTouchable) {
      stylus_geom_ = geom;
    }
  }
  target_body_ = mj_name2id(m, mjOBJ_BODY, "target");
  target_geom_ = mj_name2id(m, mjOBJ_GEOM, "target");
  for (std::size_t i = 0; i < 3; ++i) {
    nut_mass_kg_[i] =
        m->dof_armature[nuts_.dof[i]] + m->body_mass[m->dof_bodyid[nuts_.dof[i]]];
  }
  for (const Axis axis : kAxes) {
    const int i = Index(axis);
    Play& play = plays_[static_cast<std::size_t>(i)];
    play = PlayOf(axis);
    for (int j = 0; j < 3; ++j) is_coupled_ |= j != i && play.carriages[j] != 0;
  }
  couplings_ = Couplings();
  mj_forward(m, data_.get());
}

CoupledJoints World::Couplings() const {
  std::vector<int> placed;
  for (const Axis axis : kAxes) {
    for (const std::string& name :
         {Name(axis), Name(axis) + "_nut", "stylus_" + Name(axis)}) {
      placed.push_back(IdOf(model_.get(), mjOBJ_JOINT, name));
    }
  }
  return {model_.get(), placed};
}

World::Play World::PlayOf(Axis axis) const {
  const mjModel* m = model_.get();
  Play play{.tendon = IdOf(m, mjOBJ_TENDON, Name(axis) + "_play"),
            .rigid = IdOf(m, mjOBJ_EQUALITY, Name(axis) + "_rigid")};
  play.is_sprung = m->tendon_stiffness[play.tendon] > 0;
  const mjtNum* range = play.is_sprung ? m->tendon_lengthspring : m->tendon_range;
  play.middle_m =
      m->eq_active0[play.rigid] != 0
          ? m->tendon_length0[play.tendon] +
                m->eq_data[static_cast<std::ptrdiff_t>(mjNEQDATA) * play.rigid]
          : (range[2 * play.tendon] + range[2 * play.tendon + 1]) / 2;
  const auto k = static_cast<std::size_t>(Index(axis));
  for (int i = 0; i < m->tendon_num[play.tendon]; ++i) {
    const int wrap = m->tendon_adr[play.tendon] + i;
    Require(m->wrap_type[wrap] == mjWRAP_JOINT, "a play is no fixed tendon");
    const int address = m->jnt_qposadr[m->wrap_objid[wrap]];
    for (std::size_t carriage = 0; carriage < 3; ++carriage) {
      if (address == carriages_.qpos[carriage]) {
        play.carriages[static_cast<int>(carriage)] = m->wrap_prm[wrap];
      }
    }
  }
  Require(play.carriages[static_cast<int>(k)] != 0,
          "a play does not hold its carriage");
  return play;
}

World::Slots World::SlotsOf(const std::string& prefix,
                            const std::string& suffix) const {
  Slots slots;
  for (const Axis axis : kAxes) {
    const int joint = IdOf(model_.get(), mjOBJ_JOINT, prefix + Name(axis) + suffix);
    slots.qpos[static_cast<std::size_t>(Index(axis))] = model_->jnt_qposadr[joint];
    slots.dof[static_cast<std::size_t>(Index(axis))] = model_->jnt_dofadr[joint];
  }
  return slots;
}

Vec3<double> World::Read_mm(const mjtNum* values, const std::array<int, 3>& at) {
  return Vec3<double>(values[at[0]], values[at[1]], values[at[2]]) * kMmPerM;
}

double World::timestep_s() const {
  return model_->opt.timestep;
}
Vec3<double> World::Nuts_mm() const {
  return Read_mm(data_->qpos, nuts_.qpos);
}
Vec3<double> World::Carriages_mm() const {
  return Read_mm(data_->qpos, carriages_.qpos);
}
Vec3<double> World::Carriages_mm_s() const {
  return Read_mm(data_->qvel, carriages_.dof);
}
Vec3<double> World::Deflection_mm() const {
  return Read_mm(data_->qpos, stylus_.qpos);
}
Vec3<double> World::Deflection_mm_s() const {
  return Read_mm(data_->qvel, stylus_.dof);
}

// Of the z carriage's frame and the stylus' place in it: the stylus' own frame moves
// with its deflection.
Vec3<double> World::Tip_mm() const {
  mj_kinematics(model_.get(), data_.get());
  std::array<mjtNum, 3> offset_m{};
  mju_mulMatVec3(
      offset_m.data(), data_->xmat + 9 * z_body_, model_->body_pos + 3 * stylus_body_);
  return Read_mm(data_->xpos + 3 * z_body_, {0, 1, 2}) +
         Read_mm(offset_m.data(), {0, 1, 2});
}

void World::MoveTool_mm(const Vec3<double>& offset_mm) {
  for (int i = 0; i < 3; ++i) {
    model_->body_pos[3 * stylus_body_ + i] =
        stylus_pos_[static_cast<std::size_t>(i)] + offset_mm[i] * kMPerMm;
  }
}

void World::SetTable(const Vec3<double>& about_mm,
                     double height_mm,
                     double slope_x,
                     double slope_y) {
  const Vec3<double> normal = Vec3<double>(-slope_x, -slope_y, 1).normalized();
  const auto turn = Eigen::Quaterniond::FromTwoVectors(Vec3<double>::UnitZ(), normal);
  const Vec3<double> about_m = about_mm * kMPerMm;
  const Eigen::Map<const Vec3<double>> modelled_m(table_pos_.data());
  const Vec3<double> at_m =
      about_m + turn * (modelled_m - about_m) + Unit(Axis::kZ) * (height_mm * kMPerMm);
  std::copy_n(at_m.data(), 3, model_->body_pos + 3 * table_body_);
  const std::array<mjtNum, 4> quat{turn.w(), turn.x(), turn.y(), turn.z()};
  mju_mulQuat(model_->body_quat + 4 * table_body_, quat.data(), table_quat_.data());
}

void World::SetGap_mm(Axis axis, double gap_mm) {
  mjModel* m = model_.get();
  const Play& play = plays_[static_cast<std::size_t>(Index(axis))];
  const double half_m = std::max(gap_mm, 0.0) / 2 * kMPerMm;
  mjtNum* range = play.is_sprung ? m->tendon_lengthspring : m->tendon_range;
  range[2 * play.tendon] = play.middle_m - half_m;
  range[2 * play.tendon + 1] = play.middle_m + half_m;
  if (play.is_sprung) return;
  m->tendon_limited[play.tendon] = half_m > 0 ? 1 : 0;
  data_->eq_active[play.rigid] = half_m > 0 ? 0 : 1;
}

void World::SetRailFriction_n(Axis axis, double friction_n) {
  model_->dof_frictionloss[carriages_.dof[static_cast<std::size_t>(Index(axis))]] =
      friction_n;
}

void World::TurnTable(const Vec3<double>& about_mm, double turn_rad) {
  const Eigen::Quaterniond modelled(
      table_quat_[0], table_quat_[1], table_quat_[2], table_quat_[3]);
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(turn_rad, Vec3<double>::UnitZ()));
  const Vec3<double> about_m = about_mm * kMPerMm;
  const Vec3<double> at_m = Eigen::Map<const Vec3<double>>(table_pos_.data()) +
                            modelled * (about_m - turn * about_m);
  const Eigen::Quaterniond turned = modelled * turn;
  const std::array<mjtNum, 4> quat{turned.w(), turned.x(), turned.y(), turned.z()};
  std::copy_n(at_m.data(), 3, model_->body_pos + 3 * table_body_);
  std::copy_n(quat.data(), 4, model_->body_quat + 4 * table_body_);
}

void World::MakeTouchable(int geom, bool is_touchable) {
  model_->geom_contype[geom] = is_touchable ? kTouchable : 0;
  model_->geom_conaffinity[geom] = is_touchable ? kTouchable : 0;
}

void World::PlaceTarget(const Vec3<double>& at_mm, const Vec3<double>& normal) {
  Require(target_body_ >= 0, "the model has no target");
  const auto turn = Eigen::Quaterniond::FromTwoVectors(Vec3<double>::UnitZ(), normal);
  const std::array<mjtNum, 4> quat{turn.w(), turn.x(), turn.y(), turn.z()};
  for (int i = 0; i < 3; ++i) {
    model_->body_pos[3 * target_body_ + i] = at_mm[i] * kMPerMm;
  }
  std::copy_n(quat.data(), 4, model_->body_quat + 4 * target_body_);
  MakeTouchable(target_geom_, true);
  for (const int geom : touchable_) MakeTouchable(geom, false);
  is_target_touched_ = true;
}

void World::TouchTable() {
  if (target_geom_ >= 0) MakeTouchable(target_geom_, false);
  for (const int geom : touchable_) MakeTouchable(geom, true);
  is_target_touched_ = false;
}

double World::Gap_mm(Axis axis) const {
  const mjModel* m = model_.get();
  const Play& play = plays_[static_cast<std::size_t>(Index(axis))];
  if (data_->eq_active[play.rigid] != 0) return 0;
  if (!play.is_sprung && m->tendon_limited[play.tendon] == 0) return 0;
  const mjtNum* range = play.is_sprung ? m->tendon_lengthspring : m->tendon_range;
  return (range[2 * play.tendon + 1] - range[2 * play.tendon]) * kMmPerM;
}

// Puts each carriage where its play's length is the lag told: in the model as drawn
// that is where it stands already.
void World::SettlePlays(const Vec3<double>& lag_mm) {
  const mjModel* m = model_.get();
  Eigen::Matrix3d by_carriage;
  Vec3<double> off_m;
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const Play& play = plays_[k];
    double length_m = 0;
    for (int j = 0; j < m->tendon_num[play.tendon]; ++j) {
      const int wrap = m->tendon_adr[play.tendon] + j;
      length_m += m->wrap_prm[wrap] * data_->qpos[m->jnt_qposadr[m->wrap_objid[wrap]]];
    }
    off_m[i] = play.middle_m + lag_mm[i] * kMPerMm - length_m;
    by_carriage.row(i) = play.carriages;
    if (!is_coupled_) data_->qpos[carriages_.qpos[k]] += off_m[i] / play.carriages[i];
  }
  if (!is_coupled_) return;
  const Vec3<double> by_m = by_carriage.inverse() * off_m;
  for (int i = 0; i < 3; ++i) {
    data_->qpos[carriages_.qpos[static_cast<std::size_t>(i)]] += by_m[i];
  }
}

Vec3<double> World::Lag_mm(const Vec3<double>& nuts_mm,
                           const Vec3<double>& carriages_mm) const {
  if (!is_coupled_) return carriages_mm - nuts_mm;
  Vec3<double> lag_mm;
  for (int i = 0; i < 3; ++i) {
    lag_mm[i] =
        plays_[static_cast<std::size_t>(i)].carriages.dot(carriages_mm) - nuts_mm[i];
  }
  return lag_mm;
}

void World::Place(const Vec3<double>& nuts_mm,
                  const Vec3<double>& carriages_mm,
                  const Vec3<double>& nuts_mm_s,
                  const Vec3<double>& carriages_mm_s) {
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    data_->qpos[nuts_.qpos[k]] = nuts_mm[i] * kMPerMm;
    data_->qvel[nuts_.dof[k]] = nuts_mm_s[i] * kMPerMm;
    data_->qpos[carriages_.qpos[k]] = carriages_mm[i] * kMPerMm;
    data_->qvel[carriages_.dof[k]] = carriages_mm_s[i] * kMPerMm;
    data_->qpos[stylus_.qpos[k]] = 0;
    data_->qvel[stylus_.dof[k]] = 0;
  }
  for (int i = 0; i < kSettlings; ++i) {
    SettlePlays(Lag_mm(nuts_mm, carriages_mm));
    couplings_->Follow(model_.get(), data_.get());
  }
  // The solver starts from the last solution: forget it, so that a touch is the same
  // whatever came before.
  std::fill_n(data_->qacc_warmstart, model_->nv, 0.0);
  std::fill_n(data_->qacc, model_->nv, 0.0);
  data_->time = 0;
}

void World::Step(const Vec3<double>& nuts_mm) {
  const double dt = model_->opt.timestep;
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const int dof = nuts_.dof[k];
    data_->qfrc_applied[dof] =
        nut_mass_kg_[k] *
        (nuts_mm[i] * kMPerMm - data_->qpos[nuts_.qpos[k]] - dt * data_->qvel[dof]) /
        (dt * dt);
  }
  data_->qfrc_applied[carriages_.dof[2]] = -hanging_n_;
  mj_step(model_.get(), data_.get());
  for (const mjWarningStat& warning : data_->warning) {
    Require(warning.number == 0, "MuJoCo warns: the simulation is not to be trusted");
  }
}

double World::Clearance_mm(double most_mm) const {
  mj_kinematics(model_.get(), data_.get());
  double least_m = most_mm * kMPerMm;
  const auto look = [&](int geom) {
    least_m =
        std::min(least_m,
                 mj_geomDistance(
                     model_.get(), data_.get(), stylus_geom_, geom, least_m, nullptr));
  };
  if (is_target_touched_) {
    look(target_geom_);
  } else {
    for (const int geom : touchable_) look(geom);
  }
  return least_m * kMmPerM;
}

}  // namespace caltwin

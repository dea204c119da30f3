#include "sim/physics/world.h"

#include <algorithm>
#include <mutex>
#include <utility>

#include <fmt/format.h>

#include "sim/base/require.h"

namespace caltwin {
namespace {

constexpr double kMPerMm = 1e-3;
constexpr double kMmPerM = 1e3;
constexpr int kTouchable = 2;

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
  const int table = IdOf(m, mjOBJ_BODY, "table");
  const int stylus = IdOf(m, mjOBJ_BODY, "stylus");
  for (int geom = 0; geom < m->ngeom; ++geom) {
    if (m->geom_bodyid[geom] == table && m->geom_contype[geom] == kTouchable) {
      touchable_.push_back(geom);
    }
    if (m->geom_bodyid[geom] == stylus && m->geom_contype[geom] == kTouchable) {
      stylus_geom_ = geom;
    }
  }
  for (std::size_t i = 0; i < 3; ++i) {
    nut_mass_kg_[i] =
        m->dof_armature[nuts_.dof[i]] + m->body_mass[m->dof_bodyid[nuts_.dof[i]]];
  }
  mj_forward(m, data_.get());
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

Vec3<double> World::Tip_mm() const {
  mj_kinematics(model_.get(), data_.get());
  return Read_mm(data_->xpos + 3 * z_body_, {0, 1, 2});
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
  for (const int geom : touchable_) {
    least_m =
        std::min(least_m,
                 mj_geomDistance(
                     model_.get(), data_.get(), stylus_geom_, geom, least_m, nullptr));
  }
  return least_m * kMmPerM;
}

}  // namespace caltwin

#include "sim/kinds/z_station/world.h"

#include <array>
#include <cmath>

#include <Eigen/Geometry>

#include "sim/base/require.h"
#include "sim/mjcf/spec.h"

namespace caltwin {
namespace {

constexpr double kTimestep_s = 1e-3;
constexpr double kProbing_mm_s = 5;
constexpr double kStart_mm = 0.25;    // Over where pin or knob is first met.
constexpr double kMostTravel_mm = 3;  // Beyond where the trigger is expected.
constexpr double kMmPerM = 1e3;

ModelPtr Compiled(const std::filesystem::path& file) {
  constexpr double kOneSided = 1;  // Damping ratio.
  const SpecPtr spec = ReadSpec(file);
  spec->option.timestep = kTimestep_s;
  for (const char* name : {"nozzle", "probe", "knob", "pin", "surface"}) {
    mjsGeom* geom = mjs_asGeom(FindElement(spec.get(), mjOBJ_GEOM, name));
    MakeHard(kTimestep_s, kOneSided, geom->solref, geom->solimp);
  }
  ModelPtr model(mj_compile(spec.get(), nullptr));
  Require(model != nullptr, "models/z_station/model.xml compiles");
  return model;
}

int JointOf(const mjModel* model, const char* name) {
  const int joint = mj_name2id(model, mjOBJ_JOINT, name);
  Require(joint >= 0, "models/z_station/model.xml has all its joints");
  return joint;
}

}  // namespace

ZStationWorld::ZStationWorld(const std::filesystem::path& file)
    : model_(Compiled(file)),
      data_(mj_makeData(model_.get())),
      head_(JointOf(model_.get(), "head")),
      pin_(JointOf(model_.get(), "pin")),
      knob_(JointOf(model_.get(), "knob")) {}

int ZStationWorld::BodyOf(const char* name) const {
  const int body = mj_name2id(model_.get(), mjOBJ_BODY, name);
  Require(body >= 0, "models/z_station/model.xml has all its bodies");
  return body;
}

// Heights of the parts; the head stands so that what is asked for is over its place.
void ZStationWorld::Build(ZContact contact, const ZStationBuild& build) {
  const auto set_z = [&](const char* name, double z_mm) {
    model_->body_pos[3 * BodyOf(name) + 2] = z_mm * kMPerMm;
  };
  set_z("nozzle", build.tip_mm);
  set_z("probe", build.body_mm);
  set_z("knob", build.body_mm - build.trigger_mm - kInward_mm);
  set_z("pin", build.switch_mm + kInward_mm);
  set_z("surface", build.surface_mm);
  const Vec3<double> normal =
      Vec3<double>(-build.slope_x, -build.slope_y, 1).normalized();
  SetQuat(Eigen::Quaterniond::FromTwoVectors(Vec3<double>::UnitZ(), normal),
          model_->body_quat + 4 * BodyOf("surface"));
  mjtNum* head = model_->body_pos + 3 * BodyOf("head");
  const mjtNum* probe = model_->body_pos + 3 * BodyOf("probe");
  const mjtNum* surface = model_->body_pos + 3 * BodyOf("surface");
  head[0] = contact == ZContact::kBodyOnSwitch ? -probe[0] : 0;
  head[1] = contact == ZContact::kKnobOnSurface ? surface[1] : 0;
  for (const char* name : {"probe", "knob"}) {
    const int geom = mj_name2id(model_.get(), mjOBJ_GEOM, name);
    model_->geom_contype[geom] = build.has_probe ? 1 : 0;
  }
}

void ZStationWorld::PlaceHead(double carriage_mm) {
  mj_resetData(model_.get(), data_.get());
  data_->qpos[head_] = carriage_mm * kMPerMm;
  data_->qvel[head_] = -kProbing_mm_s * kMPerMm;
}

void ZStationWorld::Step(double carriage_mm) {
  const double to_m = carriage_mm * kMPerMm;
  const double mass_kg = model_->dof_armature[head_];
  data_->qfrc_applied[head_] =
      mass_kg * (to_m - data_->qpos[head_] - kTimestep_s * data_->qvel[head_]) /
      (kTimestep_s * kTimestep_s);
  mj_step(model_.get(), data_.get());
  for (const mjWarningStat& warning : data_->warning) {
    Require(warning.number == 0, "MuJoCo warns: the simulation is not to be trusted");
  }
}

std::optional<double> ZStationWorld::Lower(ZContact contact,
                                           const ZStationBuild& build,
                                           double expected_mm) {
  constexpr double kStep_mm = kProbing_mm_s * kTimestep_s;
  Build(contact, build);
  double carriage_mm = expected_mm + kInward_mm + kStart_mm;
  PlaceHead(carriage_mm);
  const auto inward_mm = [&] {
    return kMmPerM * (contact == ZContact::kKnobOnSurface ? data_->qpos[knob_]
                                                          : -data_->qpos[pin_]);
  };
  double before_mm = inward_mm();
  while (carriage_mm > expected_mm - kMostTravel_mm) {
    Step(carriage_mm - kStep_mm);
    const double now_mm = inward_mm();
    if (now_mm >= kInward_mm) {
      const double part = (kInward_mm - before_mm) / (now_mm - before_mm);
      return carriage_mm - part * kStep_mm;
    }
    before_mm = now_mm;
    carriage_mm -= kStep_mm;
  }
  return std::nullopt;
}

}  // namespace caltwin

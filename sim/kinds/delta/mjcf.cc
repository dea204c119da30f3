#include "sim/kinds/delta/mjcf.h"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "sim/base/require.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/kinds/delta/sprung_probe.h"

namespace caltwin {
namespace {

constexpr double kField_mm = 128;  // Half its width, beyond any nozzle's reach.
constexpr int kCells = 256;
constexpr double kBase_mm = 5;
constexpr double kFlat_mm = 1e-9;
constexpr const char* kProbe = "probe";
constexpr const char* kDrive = "drive_";  // Its body, joint and tendon, by tower.

mjsBody* Body(const mjSpec* spec, const std::string& name) {
  return mjs_asBody(FindElement(spec, mjOBJ_BODY, name));
}

mjsSite* Site(const mjSpec* spec, const std::string& name) {
  return mjs_asSite(FindElement(spec, mjOBJ_SITE, name));
}

bool HasShape(const DeltaBed<double>& bed) {
  return std::max({std::abs(bed.bowl_mm),
                   std::abs(bed.cylinder_x_mm),
                   std::abs(bed.cylinder_y_mm),
                   std::abs(bed.twist_mm)}) > kFlat_mm;
}

}  // namespace

DeltaMjcf DeltaMjcf::FromFile(const std::filesystem::path& file) {
  DeltaMjcf model(ReadSpec(file));
  model.CheckNames(file.string());
  return model;
}

DeltaMjcf DeltaMjcf::Copy() const {
  return DeltaMjcf(SpecPtr(mj_copySpec(spec_.get())));
}

void DeltaMjcf::CheckNames(const std::string& file) const {
  Faults faults;
  const auto check = [&](mjtObj type,
                         const std::string& kind,
                         const std::string& name) {
    if (mjs_findElement(spec_.get(), type, name.c_str()) != nullptr) return;
    faults.Add({.file = file},
               fmt::format("the model has no {} named '{}'", kind, name),
               "models/delta_printer/model.xml shows the names that caltwin drives");
  };
  for (int i = 0; i < kNumTowers; ++i) {
    check(mjOBJ_JOINT, "joint", TowerName(i));
    check(mjOBJ_BODY, "body", "carriage_" + TowerName(i));
  }
  for (int k = 0; k < kNumRods; ++k) {
    check(mjOBJ_SITE, "site", "upper_" + RodName(k));
    check(mjOBJ_SITE, "site", "lower_" + RodName(k));
    check(mjOBJ_TENDON, "tendon", "rod_" + RodName(k));
    check(mjOBJ_EQUALITY, "equality", "rod_" + RodName(k));
  }
  check(mjOBJ_BODY, "body", "bed");
  check(mjOBJ_BODY, "body", "effector");
  check(mjOBJ_GEOM, "geom", "bed");
  check(mjOBJ_GEOM, "geom", "nozzle");
  faults.ThrowIfAny();
}

void DeltaMjcf::SetTimestep_s(double timestep_s) {
  spec_->option.timestep = timestep_s;
  for (int k = 0; k < kNumRods; ++k) {
    mjsEquality* rod =
        mjs_asEquality(FindElement(spec_.get(), mjOBJ_EQUALITY, "rod_" + RodName(k)));
    MakeHard(timestep_s, /*damping_ratio=*/0.5, rod->solref, rod->solimp);
  }
  for (int tower = 0; tower < kNumTowers; ++tower) HardenPlay(tower, timestep_s);
  constexpr double kOneSided = 1;  // Damping ratio.
  for (const char* name : {"bed", "nozzle"}) {
    mjsGeom* geom = mjs_asGeom(FindElement(spec_.get(), mjOBJ_GEOM, name));
    MakeHard(timestep_s, kOneSided, geom->solref, geom->solimp);
  }
  if (mjsElement* probe = mjs_findElement(spec_.get(), mjOBJ_JOINT, kProbe)) {
    mjsJoint* joint = mjs_asJoint(probe);
    MakeHard(timestep_s, kOneSided, joint->solref_limit, joint->solimp_limit);
    mjsGeom* tip = mjs_asGeom(FindElement(spec_.get(), mjOBJ_GEOM, kProbe));
    MakeHard(timestep_s, kOneSided, tip->solref, tip->solimp);
  }
}

void DeltaMjcf::HardenPlay(int tower, double timestep_s) {
  const std::string drive = kDrive + TowerName(tower);
  mjsElement* element = mjs_findElement(spec_.get(), mjOBJ_TENDON, drive.c_str());
  if (element == nullptr) return;
  constexpr double kOneSided = 1;  // Damping ratio.
  mjsTendon* gap = mjs_asTendon(element);
  MakeHard(timestep_s, kOneSided, gap->solref_limit, gap->solimp_limit);
  mjsJoint* rail = mjs_asJoint(FindElement(spec_.get(), mjOBJ_JOINT, TowerName(tower)));
  MakeHard(timestep_s, kOneSided, rail->solref_friction, rail->solimp_friction);
}

void DeltaMjcf::AddPlay(const DeltaPlay& play) {
  constexpr double kDrive_kg = 1e-3;
  const std::string tower = TowerName(play.tower), drive = kDrive + tower;
  mjsBody* carriage = Body(spec_.get(), "carriage_" + tower);
  mjsJoint* rail = mjs_asJoint(FindElement(spec_.get(), mjOBJ_JOINT, tower));
  mjsBody* driven = mjs_addBody(Body(spec_.get(), "world"), nullptr);
  mjs_setName(driven->element, drive.c_str());
  std::copy_n(carriage->pos, 3, driven->pos);
  driven->explicitinertial = 1;
  driven->mass = kDrive_kg;
  for (double& inertia : driven->inertia) inertia = kDrive_kg * 1e-3;
  mjsJoint* motor = mjs_addJoint(driven, nullptr);
  mjs_setName(motor->element, drive.c_str());
  motor->type = mjJNT_SLIDE;
  std::copy_n(rail->axis, 3, motor->axis);
  motor->armature = rail->armature;
  rail->armature = 0;
  rail->frictionloss = play.friction_n;
  carriage->mass = play.carriage_kg;
  mjsTendon* gap = mjs_addTendon(spec_.get(), nullptr);
  mjs_setName(gap->element, drive.c_str());
  mjs_wrapJoint(gap, tower.c_str(), 1);
  mjs_wrapJoint(gap, drive.c_str(), -1);
  gap->limited = mjLIMITED_TRUE;
  gap->range[0] = -play.gap_mm / 2 * kMPerMm;
  gap->range[1] = play.gap_mm / 2 * kMPerMm;
}

void DeltaMjcf::SetEffectorMass_kg(double mass_kg) {
  Body(spec_.get(), "effector")->mass = mass_kg;
}

void DeltaMjcf::SetBuild(const DeltaBuild<double>& build) {
  const Vec3<double> at_endstops = Vec3<double>::Zero();
  const auto upper = delta_chain::UpperJoints_mm(build, at_endstops);
  const auto lower = delta_chain::LowerJoints_mm(build);
  // One mm down moves them along their towers.
  const auto below =
      delta_chain::UpperJoints_mm(build, Vec3<double>(Vec3<double>::Ones()));
  for (int i = 0; i < kNumTowers; ++i) {
    const auto k = 2 * static_cast<std::size_t>(i);
    const Vec3<double> centre = (upper[k] + upper[k + 1]) / 2;
    SetPosition(centre, Body(spec_.get(), "carriage_" + TowerName(i))->pos);
    mjsJoint* joint = mjs_asJoint(FindElement(spec_.get(), mjOBJ_JOINT, TowerName(i)));
    const Vec3<double> up = (upper[k] - below[k]).normalized();
    std::copy(up.begin(), up.end(), joint->axis);
    for (std::size_t side = 0; side < 2; ++side) {
      const std::string rod = RodName(static_cast<int>(k + side));
      SetPosition(upper[k + side] - centre, Site(spec_.get(), "upper_" + rod)->pos);
      SetPosition(lower[k + side], Site(spec_.get(), "lower_" + rod)->pos);
    }
  }
  const auto pose = DeltaPoseOf(build, at_endstops);
  Require(pose.has_value(), "the delta closes at its endstops");
  SetPosition(pose->nozzle_mm, Body(spec_.get(), "effector")->pos);
}

void DeltaMjcf::SetBed(const DeltaBed<double>& bed) {
  mjsBody* body = Body(spec_.get(), "bed");
  if (HasShape(bed)) {
    AddHeights(bed);
    return;
  }
  SetPosition({0, 0, bed.height_mm}, body->pos);
  const Vec3<double> normal = Vec3<double>(-bed.slope_x, -bed.slope_y, 1).normalized();
  SetQuat(Eigen::Quaterniond::FromTwoVectors(Vec3<double>::UnitZ(), normal),
          body->quat);
}

void DeltaMjcf::AddProbe(const Vec3<double>& off_mm) {
  constexpr double kStiffness_n_per_m = kProbeStiffness_n_per_mm / kMPerMm;
  constexpr double kTravel_m = 0.006;
  mjsGeom* nozzle = mjs_asGeom(FindElement(spec_.get(), mjOBJ_GEOM, "nozzle"));
  mjsBody* probe = mjs_addBody(Body(spec_.get(), "effector"), nullptr);
  mjs_setName(probe->element, kProbe);
  SetPosition(off_mm, probe->pos);
  probe->explicitinertial = 1;
  probe->mass = kProbeMass_kg;
  for (double& inertia : probe->inertia) inertia = kProbeMass_kg * 1e-5;
  mjsJoint* joint = mjs_addJoint(probe, nullptr);
  mjs_setName(joint->element, kProbe);
  joint->type = mjJNT_SLIDE;
  std::copy_n(Unit(Axis::kZ).data(), 3, joint->axis);
  joint->stiffness[0] = kStiffness_n_per_m;
  joint->springref = -kProbePreload_n / kStiffness_n_per_m;
  joint->limited = mjLIMITED_TRUE;
  joint->range[0] = 0;
  joint->range[1] = kTravel_m;
  mjsGeom* tip = mjs_addGeom(probe, nullptr);
  mjs_setName(tip->element, kProbe);
  tip->type = nozzle->type;
  std::copy_n(nozzle->size, 3, tip->size);
  std::copy_n(nozzle->pos, 3, tip->pos);
  tip->contype = nozzle->contype;
  tip->conaffinity = nozzle->conaffinity;
  tip->condim = nozzle->condim;
  tip->group = nozzle->group;
  nozzle->contype = nozzle->conaffinity = 0;
}

void DeltaMjcf::MoveNozzle(const Vec3<double>& off_mm) {
  mjsGeom* nozzle = mjs_asGeom(FindElement(spec_.get(), mjOBJ_GEOM, "nozzle"));
  for (int i = 0; i < 3; ++i) nozzle->pos[i] += off_mm[i] * kMPerMm;
}

// Heights from 0 to 1 between the lowest and the highest, as MuJoCo wants them; tilt
// and all, so that no corner of a cell has to be turned.
void DeltaMjcf::AddHeights(const DeltaBed<double>& bed) {
  constexpr int kNodes = kCells + 1;
  constexpr double kCell_mm = 2 * kField_mm / kCells;
  std::vector<double> heights_mm;
  for (int row = 0; row < kNodes; ++row) {
    for (int column = 0; column < kNodes; ++column) {
      heights_mm.push_back(
          bed.Height_mm(column * kCell_mm - kField_mm, row * kCell_mm - kField_mm));
    }
  }
  const auto [low, high] = std::ranges::minmax(heights_mm);
  std::vector<float> data;
  for (const double height_mm : heights_mm) {
    data.push_back(static_cast<float>((height_mm - low) / (high - low)));
  }
  mjsHField* field = mjs_addHField(spec_.get());
  mjs_setName(field->element, "bed_shape");
  field->nrow = field->ncol = kNodes;
  field->size[0] = field->size[1] = kField_mm * kMPerMm;
  field->size[2] = (high - low) * kMPerMm;
  field->size[3] = kBase_mm * kMPerMm;
  mjs_setFloat(field->userdata, data.data(), static_cast<int>(data.size()));
  mjsGeom* geom = mjs_asGeom(FindElement(spec_.get(), mjOBJ_GEOM, "bed"));
  geom->type = mjGEOM_HFIELD;
  mjs_setString(geom->hfieldname, "bed_shape");
  SetPosition({0, 0, low}, Body(spec_.get(), "bed")->pos);
}

ModelPtr DeltaMjcf::Compile(bool with_looks) const {
  SpecPtr copy(mj_copySpec(spec_.get()));
  copy->compiler.discardvisual = with_looks ? 0 : 1;
  ModelPtr model(mj_compile(copy.get(), nullptr));
  Require(model != nullptr,
          fmt::format("the delta compiles: {}", mjs_getError(copy.get())));
  return model;
}

}  // namespace caltwin

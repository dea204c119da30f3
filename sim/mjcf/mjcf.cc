#include "sim/mjcf/mjcf.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "sim/base/require.h"
#include "sim/mjcf/spec.h"

namespace caltwin {
namespace {

constexpr double kLightBody_kg = 1e-3;  // Inertia is in the joints' armature.
// Light enough to follow a retract, heavy enough not to chatter on the surface in one
// step (0.02 kg: a release is wrong by 0.35 um; 0.1 kg: by 1.2 um at a reversal).
constexpr double kStylus_kg = 0.05;
constexpr double kDampingRatio = 0.05;
constexpr int kNumBoreFlats = 720;
constexpr double kTargetHalf_mm = 20;

constexpr std::array kJoints = {
    "x", "y", "z", "x_nut", "y_nut", "z_nut", "stylus_x", "stylus_y", "stylus_z"};

void MakeTouchable(mjsGeom* geom) {
  geom->contype = geom->conaffinity = kTouchable;
  geom->condim = 1;
}

// What a person put on the table to be touched. The top that the drawing has becomes a
// solid of its own (TableOf).
bool IsOnTableByHand(mjsGeom* geom) {
  const mjsBody* body = mjs_getParent(geom->element);
  const auto name = [](mjsElement* element) {
    return std::string_view(mjs_getString(mjs_getName(element)));
  };
  return body != nullptr && name(body->element) == "table" &&
         name(geom->element) != "table_top" && geom->contype != 0;
}

mjsGeom* AddBox(mjsBody* body,
                const Vec3<double>& at_mm,
                double turn_rad,
                const Vec3<double>& half_mm) {
  mjsGeom* geom = mjs_addGeom(body, nullptr);
  geom->type = mjGEOM_BOX;
  SetPosition(at_mm, geom->pos);
  SetQuat(Eigen::Quaterniond(Eigen::AngleAxisd(turn_rad, Vec3<double>::UnitZ())),
          geom->quat);
  for (int i = 0; i < 3; ++i) geom->size[i] = half_mm[i] * kMPerMm;
  geom->mass = 0;
  MakeTouchable(geom);
  return geom;
}

}  // namespace

Mjcf Mjcf::FromFile(const std::filesystem::path& file) {
  Mjcf model(ReadSpec(file).release());
  model.CheckNames(file.string());
  return model;
}

Mjcf Mjcf::Copy() const {
  return Mjcf(mj_copySpec(spec_.get()));
}

void Mjcf::CheckNames(const std::string& file) const {
  Faults faults;
  const auto check = [&](mjtObj type,
                         const std::string& kind,
                         const std::string& name) {
    if (mjs_findElement(spec_.get(), type, name.c_str()) == nullptr) {
      faults.Add({.file = file},
                 fmt::format("the model has no {} named '{}'", kind, name),
                 "models/gantry_router/model.xml shows the names that caltwin drives");
    }
  };
  for (const char* name : kJoints) check(mjOBJ_JOINT, "joint", name);
  for (const Axis axis : kAxes) {
    check(mjOBJ_TENDON, "tendon", Name(axis) + "_play");
    check(mjOBJ_EQUALITY, "equality", Name(axis) + "_rigid");
    check(mjOBJ_BODY, "body", Name(axis) + "_carriage");
  }
  check(mjOBJ_BODY, "body", "table");
  check(mjOBJ_BODY, "body", "stylus");
  check(mjOBJ_GEOM, "geom", "tip");
  faults.ThrowIfAny();
}

mjsJoint* Mjcf::Joint(const std::string& name) const {
  return mjs_asJoint(FindElement(spec_.get(), mjOBJ_JOINT, name));
}

mjsTendon* Mjcf::Play(Axis axis) const {
  return mjs_asTendon(FindElement(spec_.get(), mjOBJ_TENDON, Name(axis) + "_play"));
}

void Mjcf::SetTimestep_s(double timestep_s) {
  mjSpec* spec = spec_.get();
  spec->option.timestep = timestep_s;
  const auto hard = [&](mjtNum* solref, mjtNum* solimp, double damping_ratio) {
    MakeHard(timestep_s, damping_ratio, solref, solimp);
  };
  for (const Axis axis : kAxes) {
    mjsJoint* joint = Joint(Name(axis));
    hard(joint->solref_friction, joint->solimp_friction, 1);
    mjsTendon* play = Play(axis);
    hard(play->solref_limit, play->solimp_limit, 1);
    mjsEquality* rigid =
        mjs_asEquality(FindElement(spec, mjOBJ_EQUALITY, Name(axis) + "_rigid"));
    hard(rigid->solref, rigid->solimp, 0.5);
  }
  for (mjsElement* element = mjs_firstElement(spec, mjOBJ_EQUALITY); element != nullptr;
       element = mjs_nextElement(spec, element)) {
    mjsEquality* equality = mjs_asEquality(element);
    if (equality->type == mjEQ_JOINT) hard(equality->solref, equality->solimp, 0.5);
  }
  for (mjsElement* element = mjs_firstElement(spec, mjOBJ_GEOM); element != nullptr;
       element = mjs_nextElement(spec, element)) {
    mjsGeom* geom = mjs_asGeom(element);
    hard(geom->solref, geom->solimp, 1);
  }
}

void Mjcf::SetMovingMass(Axis axis, double mass_kg) {
  Joint(Name(axis))->armature = mass_kg;
  for (const char* part : {"_carriage", "_nut"}) {
    mjsBody* body = mjs_asBody(FindElement(spec_.get(), mjOBJ_BODY, Name(axis) + part));
    body->explicitinertial = 1;
    body->mass = kLightBody_kg;
    body->gravcomp = 1;
    for (double& inertia : body->inertia) inertia = kLightBody_kg * 1e-3;
  }
}

void Mjcf::SetRailFriction(Axis axis, double friction_n) {
  Joint(Name(axis))->frictionloss = friction_n;
}

void Mjcf::SetStylus(double tip_radius_mm,
                     double stiffness_n_per_mm,
                     double disc_radius_mm) {
  const double stiffness_n_per_m = stiffness_n_per_mm / kMPerMm;
  mjsBody* stylus = mjs_asBody(FindElement(spec_.get(), mjOBJ_BODY, "stylus"));
  stylus->explicitinertial = 1;
  stylus->mass = kStylus_kg;
  stylus->gravcomp = 1;
  for (const Axis axis : kAxes) {
    mjsJoint* joint = Joint("stylus_" + Name(axis));
    joint->stiffness[0] = stiffness_n_per_m;
    joint->damping[0] = 2 * std::sqrt(kStylus_kg * stiffness_n_per_m);
  }
  for (mjsElement* element = mjs_firstElement(spec_.get(), mjOBJ_GEOM);
       element != nullptr;
       element = mjs_nextElement(spec_.get(), element)) {
    mjsGeom* geom = mjs_asGeom(element);
    if (IsOnTableByHand(geom)) {
      MakeTouchable(geom);
    } else {
      geom->contype = geom->conaffinity = 0;
    }
  }
  mjsGeom* disc = mjs_addGeom(stylus, nullptr);
  mjs_setName(disc->element, "disc");
  disc->type = mjGEOM_CYLINDER;
  disc->size[0] = disc_radius_mm * kMPerMm;
  disc->mass = 0;
  disc->rgba[3] = 0;
  SetTipRadius(tip_radius_mm);
  FitDisc(false);
}

void Mjcf::SetTipRadius(double radius_mm) {
  mjs_asGeom(FindElement(spec_.get(), mjOBJ_GEOM, "tip"))->size[0] =
      radius_mm * kMPerMm;
  mjs_asGeom(FindElement(spec_.get(), mjOBJ_GEOM, "disc"))->size[1] =
      radius_mm * kMPerMm;
}

void Mjcf::FitDisc(bool is_disc) {
  mjsGeom* tip = mjs_asGeom(FindElement(spec_.get(), mjOBJ_GEOM, "tip"));
  mjsGeom* disc = mjs_asGeom(FindElement(spec_.get(), mjOBJ_GEOM, "disc"));
  tip->contype = tip->conaffinity = disc->contype = disc->conaffinity = 0;
  MakeTouchable(is_disc ? disc : tip);
}

// The nut no longer holds the carriage by itself.
void Mjcf::FreeOfNut(Axis axis) {
  mjs_asEquality(FindElement(spec_.get(), mjOBJ_EQUALITY, Name(axis) + "_rigid"))
      ->active = 0;
}

void Mjcf::SetGap(Axis axis, double gap_mm) {
  if (gap_mm <= 0) return;
  FreeOfNut(axis);
  mjsTendon* play = Play(axis);
  play->limited = mjLIMITED_TRUE;
  play->range[0] = -gap_mm / 2 * kMPerMm;
  play->range[1] = gap_mm / 2 * kMPerMm;
}

void Mjcf::SetDriveStiffness(Axis axis, double stiffness_n_per_mm) {
  FreeOfNut(axis);
  mjsTendon* play = Play(axis);
  const bool has_gap = play->limited == mjLIMITED_TRUE;
  play->limited = mjLIMITED_FALSE;
  play->stiffness[0] = stiffness_n_per_mm / kMPerMm;
  play->springlength[0] = has_gap ? play->range[0] : 0;
  play->springlength[1] = has_gap ? play->range[1] : 0;
  // Structural damping; none with a gap, where it would drag the carriage across.
  const double critical =
      2 * std::sqrt(play->stiffness[0] * Joint(Name(axis))->armature);
  play->damping[0] = has_gap ? 0 : kDampingRatio * critical;
}

void Mjcf::TurnAxis(Axis axis, Axis about, double angle_rad, double pivot_mm) {
  const Eigen::AngleAxisd turn(angle_rad, Unit(about));
  mjsJoint* rail = Joint(Name(axis));
  const Vec3<double> before(rail->axis[0], rail->axis[1], rail->axis[2]);
  const Vec3<double> after = turn * before;
  for (const std::string& name : {Name(axis), Name(axis) + "_nut"}) {
    for (int i = 0; i < 3; ++i) Joint(name)->axis[i] = after[i];
  }
  mjsBody* carriage =
      mjs_asBody(FindElement(spec_.get(), mjOBJ_BODY, Name(axis) + "_carriage"));
  for (int i = 0; i < 3; ++i) {
    carriage->pos[i] += (before - after)[i] * pivot_mm * kMPerMm;
  }
}

// A joint behind the axis' own, tied to it by c0 + c1 U + c2 U^2. Beside the light
// carriages its own inertia makes it stiff; tied as it is, it slows nothing.
mjsJoint* Mjcf::AddErrorJoint(Axis axis,
                              const std::array<double, 3>& over_travel,
                              const AxisDrawing& travel) {
  int number = 0;
  for (mjsElement* element = mjs_firstElement(spec_.get(), mjOBJ_EQUALITY);
       element != nullptr;
       element = mjs_nextElement(spec_.get(), element)) {
    ++number;
  }
  const std::string name = fmt::format("{}_error_{}", Name(axis), number);
  mjsJoint* joint = mjs_addJoint(
      mjs_asBody(FindElement(spec_.get(), mjOBJ_BODY, Name(axis) + "_carriage")),
      nullptr);
  mjs_setName(joint->element, name.c_str());
  joint->armature = 1;
  mjsEquality* tie = mjs_addEquality(spec_.get(), nullptr);
  tie->type = mjEQ_JOINT;
  tie->objtype = mjOBJ_JOINT;
  mjs_setString(tie->name1, name.c_str());
  mjs_setString(tie->name2, Name(axis).c_str());
  const auto& [c0, c1, c2] = over_travel;
  const double half_m = travel.travel_mm() / 2 * kMPerMm;
  const double middle = travel.mid_mm() * kMPerMm / half_m;  // In U.
  std::fill_n(tie->data, mjNEQDATA, 0.0);
  tie->data[0] = c0 - c1 * middle + c2 * middle * middle;
  tie->data[1] = (c1 - 2 * c2 * middle) / half_m;
  tie->data[2] = c2 / (half_m * half_m);
  return joint;
}

void Mjcf::BendRail(Axis axis, Axis across, double bow_mm, const AxisDrawing& travel) {
  const double bow_m = bow_mm * kMPerMm;
  mjsJoint* joint = AddErrorJoint(axis, {-bow_m / 3, 0, bow_m}, travel);
  joint->type = mjJNT_SLIDE;
  for (int i = 0; i < 3; ++i) joint->axis[i] = Unit(across)[i];
}

void Mjcf::TwistRail(Axis axis,
                     Axis about,
                     double change_rad,
                     const Vec3<double>& pivot_mm,
                     const AxisDrawing& travel) {
  mjsJoint* joint = AddErrorJoint(axis, {0, change_rad / 2, 0}, travel);
  joint->type = mjJNT_HINGE;
  SetPosition(pivot_mm, joint->pos);
  for (int i = 0; i < 3; ++i) joint->axis[i] = Unit(about)[i];
}

void Mjcf::TiltTable(double slope_x_rad,
                     double slope_y_rad,
                     const Vec3<double>& about_mm) {
  const Vec3<double> normal = Vec3<double>(-slope_x_rad, -slope_y_rad, 1).normalized();
  const auto turn = Eigen::Quaterniond::FromTwoVectors(Vec3<double>::UnitZ(), normal);
  mjsBody* table = mjs_asBody(FindElement(spec_.get(), mjOBJ_BODY, "table"));
  SetQuat(turn, table->quat);
  SetPosition(about_mm - turn * about_mm, table->pos);
}

void Mjcf::AddSolid(const std::string& name, const Solid& solid) {
  mjsBody* table = mjs_asBody(FindElement(spec_.get(), mjOBJ_BODY, "table"));
  if (solid.bore_radius_mm <= 0) {
    mjsGeom* box = AddBox(table, solid.center_mm, solid.turn_rad, solid.half_mm);
    mjs_setName(box->element, name.c_str());
    return;
  }
  const double wall_mm = solid.half_mm[0] - solid.bore_radius_mm;
  const double flat_mm =
      solid.bore_radius_mm * std::tan(std::numbers::pi / kNumBoreFlats) * 1.05;
  for (int i = 0; i < kNumBoreFlats; ++i) {
    const double angle_rad = solid.turn_rad + 2 * std::numbers::pi * i / kNumBoreFlats;
    const double middle_mm = solid.bore_radius_mm + wall_mm / 2;
    const Vec3<double> out(std::cos(angle_rad), std::sin(angle_rad), 0);
    AddBox(table,
           solid.center_mm + middle_mm * out,
           angle_rad,
           {wall_mm / 2, flat_mm, solid.half_mm[2]});
  }
}

void Mjcf::AddTarget() {
  mjsBody* target =
      mjs_addBody(mjs_asBody(FindElement(spec_.get(), mjOBJ_BODY, "table")), nullptr);
  mjs_setName(target->element, "target");
  mjsGeom* block = AddBox(target,
                          Vec3<double>(0, 0, -kTargetHalf_mm),
                          0,
                          Vec3<double>::Constant(kTargetHalf_mm));
  mjs_setName(block->element, "target");
}

ModelPtr Mjcf::Compile(bool with_looks) const {
  spec_->compiler.discardvisual = !with_looks;
  ModelPtr model(mj_compile(spec_.get(), nullptr));
  Require(model != nullptr, fmt::format("MuJoCo: {}", mjs_getError(spec_.get())));
  return model;
}

std::string Mjcf::ToText() const {
  Compile(true);
  std::vector<char> text(1'000'000);
  std::array<char, 1000> error{};
  const int failed = mj_saveXMLString(spec_.get(),
                                      text.data(),
                                      static_cast<int>(text.size()),
                                      error.data(),
                                      error.size());
  Require(failed == 0, error.data());
  return text.data();
}

}  // namespace caltwin

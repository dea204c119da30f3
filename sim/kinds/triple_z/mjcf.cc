#include "sim/kinds/triple_z/mjcf.h"

#include <algorithm>

#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "sim/base/require.h"
#include "sim/machine/kinds/triple_z/drawing.h"

namespace caltwin {
namespace {

Vec3<double> Flat(const Eigen::Vector2d& at_mm) {
  return {at_mm[0], at_mm[1], 0};
}

void MoveBody(mjSpec* spec, const std::string& name, const Eigen::Vector2d& to_mm) {
  mjsElement* element = mjs_findElement(spec, mjOBJ_BODY, name.c_str());
  if (element == nullptr) return;
  SetPosition(Flat(to_mm), mjs_asBody(element)->pos);
}

}  // namespace

TripleZMjcf TripleZMjcf::FromFile(const std::filesystem::path& file) {
  TripleZMjcf model(ReadSpec(file));
  model.CheckNames(file.string());
  return model;
}

void TripleZMjcf::CheckNames(const std::string& file) const {
  Faults faults;
  const auto check = [&](mjtObj type,
                         const std::string& kind,
                         const std::string& name) {
    if (mjs_findElement(spec_.get(), type, name.c_str()) != nullptr) return;
    faults.Add({.file = file},
               fmt::format("the model has no {} named '{}'", kind, name),
               "models/triple_z_printer/model.xml shows the names that caltwin drives");
  };
  for (int i = 0; i < kNumScrews; ++i) {
    check(mjOBJ_JOINT, "joint", ScrewName(i));
    check(mjOBJ_BODY, "body", "nut_" + ScrewName(i));
  }
  for (const char* joint : {"bed", "groove", "flat_x", "flat_y"}) {
    check(mjOBJ_JOINT, "joint", joint);
  }
  for (const char* body : {"bed", "groove", "flat", "head"}) {
    check(mjOBJ_BODY, "body", body);
  }
  for (const char* ball : {"cup_ball", "groove_ball", "flat_ball"}) {
    check(mjOBJ_EQUALITY, "equality", ball);
  }
  for (const char* geom : {"nozzle", "spot"}) check(mjOBJ_GEOM, "geom", geom);
  faults.ThrowIfAny();
}

void TripleZMjcf::SetTimestep_s(double timestep_s) {
  constexpr double kTwoSided = 0.5, kOneSided = 1;  // Damping ratios.
  spec_->option.timestep = timestep_s;
  for (const char* name : {"cup_ball", "groove_ball", "flat_ball"}) {
    mjsEquality* ball = mjs_asEquality(FindElement(spec_.get(), mjOBJ_EQUALITY, name));
    MakeHard(timestep_s, kTwoSided, ball->solref, ball->solimp);
  }
  for (const char* name : {"nozzle", "spot"}) {
    mjsGeom* geom = mjs_asGeom(FindElement(spec_.get(), mjOBJ_GEOM, name));
    MakeHard(timestep_s, kOneSided, geom->solref, geom->solimp);
  }
}

void TripleZMjcf::SetPivots(const Pivots<double>& pivots_mm) {
  for (int i = 0; i < kNumScrews; ++i) {
    const Eigen::Vector2d& at_mm = pivots_mm[static_cast<std::size_t>(i)];
    MoveBody(spec_.get(), "nut_" + ScrewName(i), at_mm);
    MoveBody(spec_.get(), "screw_" + ScrewName(i), at_mm);
  }
  MoveBody(spec_.get(), "groove", pivots_mm[1]);
  MoveBody(spec_.get(), "flat", pivots_mm[2]);
  // The cup's ball is where both bodies have screw 1.
  const Vec3<double> along = Flat(pivots_mm[1] - pivots_mm[0]).normalized();
  mjsJoint* groove = mjs_asJoint(FindElement(spec_.get(), mjOBJ_JOINT, "groove"));
  std::copy(along.begin(), along.end(), groove->axis);
}

void TripleZMjcf::LetScrewsGive(double nut_kg, double damping_n_s_per_m) {
  for (int i = 0; i < kNumScrews; ++i) {
    mjsJoint* joint =
        mjs_asJoint(FindElement(spec_.get(), mjOBJ_JOINT, ScrewName(i).c_str()));
    joint->armature = nut_kg;
    joint->damping[0] = damping_n_s_per_m;
  }
  std::fill_n(spec_->option.gravity, 3, 0.0);
}

ModelPtr TripleZMjcf::Compile(bool with_looks) const {
  SpecPtr copy(mj_copySpec(spec_.get()));
  copy->compiler.discardvisual = with_looks ? 0 : 1;
  ModelPtr model(mj_compile(copy.get(), nullptr));
  Require(model != nullptr,
          fmt::format("the printer compiles: {}", mjs_getError(copy.get())));
  return model;
}

}  // namespace caltwin

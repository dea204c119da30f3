#include "renders/kinds/delta_scene.h"

#include "sim/base/input_error.h"
#include "sim/kinds/delta/plant.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {
namespace {

const Vec3<double> kNozzle_mm(30, 18, 45);

double Further(double drawn, double built, double times) {
  return drawn + times * (built - drawn);
}

template <std::size_t n>
void Further(const std::array<double, n>& drawn,
             double times,
             std::array<double, n>* built) {
  for (std::size_t i = 0; i < n; ++i) {
    (*built)[i] = Further(drawn[i], (*built)[i], times);
  }
}

DeltaBuild<double> Exaggerated(const DeltaBuild<double>& drawn,
                               DeltaBuild<double> built,
                               double times) {
  Further(drawn.model.endstop_mm, times, &built.model.endstop_mm);
  Further(drawn.model.radius_mm, times, &built.model.radius_mm);
  Further(drawn.model.angle_rad, times, &built.model.angle_rad);
  Further(drawn.model.arm_mm, times, &built.model.arm_mm);
  Further(drawn.rod_error_mm, times, &built.rod_error_mm);
  Further(drawn.lean_radial_rad, times, &built.lean_radial_rad);
  Further(drawn.lean_tangential_rad, times, &built.lean_tangential_rad);
  Further(drawn.twist_rad, times, &built.twist_rad);
  built.tool_tilt_x_rad *= times;
  built.tool_tilt_y_rad *= times;
  return built;
}

}  // namespace

DeltaScene::DeltaScene(const Machine& machine,
                       const BuiltDelta& built,
                       double exaggerate)
    : drawn_(DeltaOf(machine).model),
      build_(Exaggerated(DeltaOf(machine).Build(), built.build, exaggerate)) {
  const Vec3<double> motors_mm = DeltaMotors_mm(drawn_, kNozzle_mm);
  if (!DeltaPoseOf(build_, motors_mm) ||
      !DeltaPoseOf<double>(build_, Vec3<double>::Zero())) {
    throw InputError({.file = "--exaggerate"},
                     "its rods do not reach with errors that large",
                     "a smaller number");
  }
  DeltaMjcf model = ModelOfDelta(machine);
  model.SetBuild(build_);
  DeltaBed<double> bed = built.bed;
  bed.slope_x *= exaggerate;
  bed.slope_y *= exaggerate;
  bed.bowl_mm = bed.cylinder_x_mm = bed.cylinder_y_mm = bed.twist_mm = 0;
  model.SetBed(bed);
  world_ = std::make_unique<DeltaWorld>(model.Compile(/*with_looks=*/true), build_);
  MoveTo(kNozzle_mm);
}

bool DeltaScene::MoveTo(const Vec3<double>& nozzle_mm) {
  const Vec3<double> motors_mm = DeltaMotors_mm(drawn_, nozzle_mm);
  if (!motors_mm.allFinite()) return false;
  const auto pose = DeltaPoseOf(build_, motors_mm);
  if (!pose) return false;
  world_->Place(motors_mm, *pose, Vec3<double>::Zero(), Vec3<double>::Zero());
  mj_forward(world_->model(), world_->data());
  return true;
}

}  // namespace caltwin

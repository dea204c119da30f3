#include "renders/kinds/triple_z_scene.h"

#include <algorithm>

#include "sim/machine/kinds/triple_z/drawing.h"

namespace caltwin {
namespace {

const Vec3<double> kNozzle_mm(150, 130, 60);
constexpr double kSteepest = 0.2;  // Of a bed that is drawn.

// How far each screw stands above the middle, so that the bed has its own tilt,
// enlarged.
Vec3<double> Tilt_mm(const BuiltTripleZ& built,
                     const Pivots<double>& pivots_mm,
                     double times) {
  const double middle_mm =
      TrueBedHeight_mm(built, Vec3<double>::Zero(), kNozzle_mm.head<2>());
  Vec3<double> tilt_mm;
  for (int i = 0; i < kNumScrews; ++i) {
    const Eigen::Vector2d& at_mm = pivots_mm[static_cast<std::size_t>(i)];
    const double reach_mm = kSteepest * (at_mm - kNozzle_mm.head<2>()).norm();
    const double off_mm =
        times * (TrueBedHeight_mm(built, Vec3<double>::Zero(), at_mm) - middle_mm);
    tilt_mm[i] = std::clamp(off_mm, -reach_mm, reach_mm);
  }
  return tilt_mm;
}

}  // namespace

TripleZScene::TripleZScene(const BuiltTripleZ& built, double exaggerate)
    : top_mm_(TripleZOf(built.machine).top_mm) {
  const Pivots<double> pivots_mm = BuiltPivots_mm(built.machine, built.effects);
  tilt_mm_ = Tilt_mm(built, pivots_mm, exaggerate);
  world_ = std::make_unique<TripleZWorld>(
      WorldOfTripleZ(built.machine, pivots_mm, /*with_looks=*/true));
  MoveTo(kNozzle_mm);
}

void TripleZScene::MoveTo(const Vec3<double>& tip_mm) {
  world_->HangNozzle({tip_mm[0], tip_mm[1], top_mm_});
  world_->Place(tilt_mm_.array() + (top_mm_ - tip_mm[2]), /*speed_mm_s=*/0);
  mj_forward(world_->model(), world_->data());
}

}  // namespace caltwin

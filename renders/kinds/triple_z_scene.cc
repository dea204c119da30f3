#include "renders/kinds/triple_z_scene.h"

#include <algorithm>

#include "sim/machine/kinds/triple_z/drawing.h"

namespace caltwin {
namespace {

const Vec3<double> kNozzle_mm(150, 130, 60);
constexpr double kSteepest = 0.2;  // Of a bed that is drawn.

// Heights over the lower endstops at which the bed has its own tilt, enlarged.
Vec3<double> Heights_mm(const BuiltTripleZ& built,
                        const Pivots<double>& pivots_mm,
                        double times) {
  const double level_mm = TripleZOf(built.machine).top_mm - kNozzle_mm[2];
  const double middle_mm =
      TrueBedHeight_mm(built, Vec3<double>::Zero(), kNozzle_mm.head<2>());
  Vec3<double> heights_mm;
  for (int i = 0; i < kNumScrews; ++i) {
    const Eigen::Vector2d& at_mm = pivots_mm[static_cast<std::size_t>(i)];
    const double reach_mm = kSteepest * (at_mm - kNozzle_mm.head<2>()).norm();
    const double off_mm =
        times * (TrueBedHeight_mm(built, Vec3<double>::Zero(), at_mm) - middle_mm);
    heights_mm[i] = level_mm + std::clamp(off_mm, -reach_mm, reach_mm);
  }
  return heights_mm;
}

}  // namespace

TripleZScene::TripleZScene(const BuiltTripleZ& built, double exaggerate) {
  const Pivots<double> pivots_mm = BuiltPivots_mm(built.machine, built.effects);
  world_ = std::make_unique<TripleZWorld>(
      WorldOfTripleZ(built.machine, pivots_mm, /*with_looks=*/true));
  Vec3<double> tip_mm = kNozzle_mm;
  tip_mm[2] = TripleZOf(built.machine).top_mm;
  world_->HangNozzle(tip_mm);
  world_->Place(Heights_mm(built, pivots_mm, exaggerate), /*speed_mm_s=*/0);
  mj_forward(world_->model(), world_->data());
}

}  // namespace caltwin

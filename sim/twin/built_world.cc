#include "sim/twin/built_world.h"

#include <fmt/format.h>

#include "sim/effects/acts/acts.h"

namespace caltwin {
namespace {

ModelPtr Compiled(const Mjcf& drawn, const Built& built) {
  Mjcf model = drawn.Copy();
  EditModel(built.machine, built.effects, &model);
  for (std::size_t i = 0; i < built.solids.size(); ++i) {
    model.AddSolid(fmt::format("solid_{}", i), built.solids[i]);
  }
  model.SetTimestep_s(BuiltWorld::kTimestep_s);
  model.FitDisc(built.stylus == Stylus::kDisc);
  return model.Compile(/*with_looks=*/false);
}

}  // namespace

double HangingLoad_n(const Machine& machine) {
  const AxisDrawing& z = machine.axis(Axis::kZ);
  return z.moving_mass_kg * kGravity_m_s2 - z.counterbalance_n;
}

BuiltWorld::BuiltWorld(const Mjcf& drawn, const Built& built)
    : World(Compiled(drawn, built), HangingLoad_n(built.machine)) {
  for (const Axis axis : kAxes) drawn_gap_mm_[Index(axis)] = Gap_mm(axis);
  gap_mm_ = drawn_gap_mm_;
}

void BuiltWorld::Feel(const Built& built,
                      const Vec3<double>& steps,
                      const Vec3<double>& moved_mm) {
  const Vec3<double> q_mm = built.Drawn_mm(steps);
  if (!built.drive_effects.empty()) {
    const Vec3<double> wider_mm = built.LocalLostMotion_mm(q_mm);
    for (const Axis axis : kAxes) {
      const int i = Index(axis);
      const double gap_mm = drawn_gap_mm_[i] + wider_mm[i];
      if (gap_mm != gap_mm_[i]) SetGap_mm(axis, gap_mm);
      gap_mm_[i] = gap_mm;
    }
  }
  is_tool_moved_ |= !built.tool_effects.empty() || !moved_mm.isZero();
  if (is_tool_moved_) MoveTool_mm(built.ToolOffset_mm(q_mm) + moved_mm);
  if (built.raising_effects.empty()) return;
  const Vec3<double> tip_mm = q_mm + built.now.probe_off_mm;
  const double height_mm = built.Raised_mm(tip_mm);
  // A ball meets the point below it; a disc feels the slope.
  const bool is_disc = built.stylus == Stylus::kDisc;
  const auto slope = [&](Axis axis) {
    return is_disc ? built.Raised_mm(tip_mm + Unit(axis)) - height_mm : 0;
  };
  SetTable(tip_mm, height_mm, slope(Axis::kX), slope(Axis::kY));
}

void BuiltWorld::StandAt(const Built& built,
                         const Vec3<double>& steps,
                         const Vec3<double>& lag_mm,
                         const Vec3<double>& moved_mm) {
  Feel(built, steps, moved_mm);
  const Vec3<double> motors_mm = built.Motors_mm(steps);
  const Vec3<double> still = Vec3<double>::Zero();
  Place(motors_mm, AxesOf(built.drives(), motors_mm + lag_mm), still, still);
}

std::optional<double> BuiltWorld::BeyondTrigger_mm(const Built& built) const {
  const Vec3<double> deflection_mm = Deflection_mm();
  const double size_mm = deflection_mm.norm();
  if (size_mm < kAtRest_mm) return std::nullopt;
  return size_mm - built.Pretravel_mm(deflection_mm / size_mm);
}

std::optional<double> BuiltWorld::RestsBeyondTrigger_mm(const Built& built,
                                                        const Vec3<double>& steps) {
  constexpr double kSeen_mm = 1, kAtRest_mm_s = 1e-3;
  constexpr int kLeastSteps = 20, kMostSteps = 1000;
  if (Clearance_mm(kSeen_mm) > 0) return std::nullopt;
  const Vec3<double> motors_mm = built.Motors_mm(steps);
  for (int i = 0; i < kMostSteps; ++i) {
    if (i >= kLeastSteps && Deflection_mm_s().norm() < kAtRest_mm_s) break;
    Step(motors_mm);
  }
  return BeyondTrigger_mm(built);
}

}  // namespace caltwin

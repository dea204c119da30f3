#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "sim/kinds/delta/world.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {
namespace {

constexpr double kAgree_mm = 0.02e-3;
constexpr const char* kModel = CALTWIN_SOURCE_DIR "/models/delta_printer/model.xml";

DeltaBuild<double> Drawn() {
  return {.model = SymmetricDelta(300, 130, 250)};
}

struct WrongDelta {
  std::string name{};
  DeltaBuild<double> build = Drawn();
  DeltaBed<double> bed{};
  DeltaTip tip{};
};

// Every way of being wrong, alone, and all at once.
std::vector<WrongDelta> WrongDeltas() {
  const double deg = M_PI / 180;
  const auto with = [](const std::string& name,
                       const std::function<void(WrongDelta*)>& edit) {
    WrongDelta wrong{.name = name};
    edit(&wrong);
    return wrong;
  };
  std::vector<WrongDelta> all;
  all.push_back({.name = "as_drawn"});
  all.push_back(with("endstop", [](auto* w) { w->build.model.endstop_mm[0] += 0.8; }));
  all.push_back(with("radius", [](auto* w) { w->build.model.radius_mm[1] += 0.7; }));
  all.push_back(
      with("angle", [&](auto* w) { w->build.model.angle_rad[2] += 0.4 * deg; }));
  all.push_back(with("arm", [](auto* w) { w->build.model.arm_mm.fill(250.6); }));
  for (int rod = 0; rod < kNumRods; ++rod) {
    all.push_back(with("rod_" + RodName(rod), [&](auto* w) {
      w->build.rod_error_mm[static_cast<std::size_t>(rod)] = 0.3;
    }));
  }
  all.push_back(
      with("lean_radial", [](auto* w) { w->build.lean_radial_rad[0] = 0.003; }));
  all.push_back(with("lean_tangential",
                     [](auto* w) { w->build.lean_tangential_rad[1] = -0.003; }));
  all.push_back(with("twist", [&](auto* w) { w->build.twist_rad[2] = 0.8 * deg; }));
  all.push_back(with("belt", [](auto* w) { w->build.belt_scale[0] = 0.001; }));
  all.push_back(with("tool_tilt", [](auto* w) { w->build.tool_tilt_x_rad = 0.01; }));
  all.push_back(with("bed_tilt", [](auto* w) {
    w->bed.slope_x = 0.002;
    w->bed.slope_y = -0.004;
  }));
  all.push_back(with("bed_bowl", [](auto* w) { w->bed.bowl_mm = 0.15; }));
  all.push_back(with("bed_cylinder", [](auto* w) { w->bed.cylinder_x_mm = 0.15; }));
  all.push_back(with("bed_twist", [](auto* w) { w->bed.twist_mm = 0.1; }));
  all.push_back(with("all", [&](auto* w) {
    w->build.model.endstop_mm = {300.3, 299.8, 300.45};
    w->build.model.radius_mm = {130.8, 130.6, 131};
    w->build.model.angle_rad[0] += 0.35 * deg;
    w->build.rod_error_mm = {0.3, -0.2, 0.1, 0, -0.4, 0.2};
    w->build.lean_radial_rad = {0.003, -0.002, 0.001};
    w->build.lean_tangential_rad = {-0.002, 0.001, 0.003};
    w->build.twist_rad = {0.01, -0.01, 0.005};
    w->build.belt_scale = {0.001, 0, -0.0005};
    w->build.tool_tilt_y_rad = 0.005;
    w->bed = {.height_mm = 0.2,
              .slope_x = 0.002,
              .slope_y = -0.001,
              .bowl_mm = 0.1,
              .twist_mm = 0.05};
  }));
  return all;
}

// The same machines with what else they may touch with.
std::vector<WrongDelta> WithEveryTip() {
  const std::vector<WrongDelta> machines = WrongDeltas();
  std::vector<WrongDelta> all = machines;
  const auto add = [&](const char* name, const DeltaTip& tip) {
    for (WrongDelta machine : {machines.front(), machines.back()}) {
      machine.name += name;
      machine.tip = tip;
      all.push_back(machine);
    }
  };
  add("_hard_probe_aside", {.off_mm = {25, -10, -2}});
  add("_sprung_nozzle", {.pretravel_mm = 0.3});
  add("_sprung_probe_aside", {.off_mm = {25, -10, -2}, .pretravel_mm = 0.3});
  add("_short_pretravel", {.off_mm = {25, -10, -2}, .pretravel_mm = 0.02});
  return all;
}

class DeltaPhysics : public ::testing::TestWithParam<WrongDelta> {};

TEST_P(DeltaPhysics, TouchesWhereSixRodsSay) {
  const WrongDelta& wrong = GetParam();
  DeltaMjcf model = DeltaMjcf::FromFile(kModel);
  const bool is_sprung = wrong.tip.pretravel_mm > 0;
  if (is_sprung) model.AddProbe(wrong.tip.off_mm);
  if (!is_sprung) model.MoveNozzle(wrong.tip.off_mm);
  model.SetTimestep_s(TouchTimestep_s(wrong.tip));
  model.SetBuild(wrong.build);
  model.SetBed(wrong.bed);
  DeltaWorld world(model.Compile(/*with_looks=*/false), wrong.build);
  const DeltaModel<double> settings = Drawn().model;
  double most_mm = 0;
  for (const auto& [x, y] : {std::pair(0, 0), {95, 0}, {-40, 70}, {20, -90}}) {
    const Vec3<double> place_mm(x, y, 0);
    const auto descent = [&](double z_mm) {
      return DeltaMotors_mm<double>(settings, place_mm + z_mm * Unit(Axis::kZ));
    };
    const auto exact =
        DeltaTouchHeight_mm(wrong.build, wrong.bed, descent, /*near_mm=*/0, wrong.tip);
    const auto touched = TouchInPhysics_mm(&world,
                                           wrong.build,
                                           wrong.bed,
                                           descent,
                                           /*near_mm=*/0,
                                           {.tip = wrong.tip});
    ASSERT_TRUE(exact);
    ASSERT_TRUE(touched) << x << " " << y;
    most_mm = std::max(most_mm, std::abs(*touched - *exact));
  }
  RecordProperty("most_mm", std::to_string(most_mm));
  EXPECT_LT(most_mm, kAgree_mm);
}

INSTANTIATE_TEST_SUITE_P(Every,
                         DeltaPhysics,
                         ::testing::ValuesIn(WithEveryTip()),
                         [](const auto& each) { return each.param.name; });

}  // namespace
}  // namespace caltwin

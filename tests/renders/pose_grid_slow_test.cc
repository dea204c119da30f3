#include <filesystem>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "renders/pose_grid.h"
#include "sim/base/rng.h"

namespace caltwin {
namespace {

constexpr double kTolerance_mm = 0.5;

Scenario Named(const std::string& name) {
  return ReadScenario(std::filesystem::path(CALTWIN_SOURCE_DIR) / "scenarios" /
                      (name + ".yaml"));
}

/// Somewhere in the travel, or as far again beyond it as `beyond` says.
Vec3<double> SomePlace_mm(const Still& still, double beyond, Rng* rng) {
  Vec3<double> at_mm;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto [least, most] = still.travel_mm[axis];
    const double share = rng->Uniform() * (1 + 2 * beyond) - beyond;
    at_mm[static_cast<Eigen::Index>(axis)] = least + share * (most - least);
  }
  return at_mm;
}

/// How far the grid is off at most at a thousand places that the machine reaches.
double WorstOf(const Still& still, const PoseGrid& grid, double beyond = 0) {
  Rng rng(1, 0, "pose grid");
  double worst_mm = 0;
  for (int i = 0; i < 1000; ++i) {
    const Vec3<double> at_mm = SomePlace_mm(still, beyond, &rng);
    const auto held = PosesAt(grid, at_mm);
    if (!still.move_to(at_mm) || !held) continue;
    worst_mm = std::max(worst_mm, Apart_mm(*held, PosesOf(*still.data, grid.bodies)));
  }
  return worst_mm;
}

class Straight : public ::testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(PoseGrid,
                         Straight,
                         ::testing::Values("first_light",
                                           "corexy_by_dials",
                                           "tz_levels_in_one_round"));

TEST_P(Straight, TwoNodesAlongEachAxisHoldEveryPose) {
  const Scenario scenario = Named(GetParam());
  for (const double exaggerate : {1.0, 30.0}) {
    const Still still = StillOf(scenario, scenario.seed, exaggerate);

    const PoseGrid grid = GridOfPoses(still, kTolerance_mm);

    EXPECT_TRUE(grid.IsStraight());
    EXPECT_LT(WorstOf(still, grid), 0.01);
    EXPECT_LT(WorstOf(still, grid, /*beyond=*/0.2), 0.01);
  }
}

// Half-way along x and along y at once it is off by twice what is allowed along one; at
// the edge of the bed, where a rod lies flat, by more.
TEST(PoseGrid, HoldsADeltaOverItsBed) {
  const Scenario scenario = Named("delta_joint_recovers");
  const Still still = StillOf(scenario, scenario.seed, /*exaggerate=*/1);
  const double radius_mm = still.travel_mm[0][1];

  const PoseGrid grid = GridOfPoses(still, kTolerance_mm);

  EXPECT_EQ(grid.nodes_mm[2].size(), 2);  // Its carriages rise as its nozzle does.
  const auto worst_within = [&](double most_mm) {
    Rng rng(1, 0, "pose grid");
    double worst_mm = 0;
    for (int i = 0; i < 1000; ++i) {
      const Vec3<double> at_mm = SomePlace_mm(still, 0, &rng);
      if (at_mm.head<2>().norm() > most_mm) continue;
      const auto held = PosesAt(grid, at_mm);
      EXPECT_TRUE(still.move_to(at_mm) && held) << at_mm.transpose();
      if (!held) continue;
      worst_mm = std::max(worst_mm, Apart_mm(*held, PosesOf(*still.data, grid.bodies)));
    }
    return worst_mm;
  };
  EXPECT_LT(worst_within(0.8 * radius_mm), 2 * kTolerance_mm);
  EXPECT_LT(worst_within(radius_mm), 2);
}

TEST(PoseGrid, IsWrittenToTheMicrometre) {
  PoseGrid grid{.nodes_mm = {{{0, 1}, {0, 1}, {0, 1}}}, .bodies = {3}};
  grid.poses.emplace_back(std::vector<BodyPose>{{1.23456, 0, 0, 0.123456789, 0, 0, 1}});
  grid.poses.emplace_back(std::nullopt);

  EXPECT_EQ(ToJson(grid)["poses"].dump(),
            "[[[1.235,0.0,0.0,0.12346,0.0,0.0,1.0]],null]");
}

}  // namespace
}  // namespace caltwin

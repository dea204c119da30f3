// What plans of a triple-Z printer can and cannot see, and its baseline.

#include <algorithm>
#include <string>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/diagnosis/atlas.h"

namespace caltwin {
namespace {

Observed Planned(const std::string& campaigns) {
  const Machine machine = ReadMachine("models/triple_z_printer/machine.yaml");
  PlannedSession session = PlanSession(
      ReadPlanText("instruments: {probe: {sigma_um: 5}, laser: {kind: laser, sigma_um: "
                   "5}, indicator: {kind: dial, sigma_um: 2}}\ncampaigns: " +
                       campaigns,
                   "plan.yaml"),
      machine,
      1);
  return {{.rows = std::move(session.rows)}, std::move(session.header), machine, {}};
}

Atlas AtlasFor(const Observed& observed) {
  std::vector<Candidate> candidates = AllCandidates(observed);
  // Those that the claims below are about.
  std::erase_if(candidates, [](const Candidate& one) {
    return one.cause != "screw_pitch" && one.cause != "angular" &&
           one.cause != "pivot_position" && one.cause != "motors_swapped" &&
           one.cause != "overconstrained_bed";
  });
  return AtlasOf(observed, candidates, PlannedSigma_mm(observed));
}

bool AreConfounded(const Atlas& atlas, const std::string& a, const std::string& b) {
  return std::ranges::any_of(atlas.confounded, [&](const ConfoundedPair& pair) {
    const std::string one = pair.first.Name(), other = pair.second.Name();
    return (one == a && other == b) || (one == b && other == a);
  });
}

bool IsIn(const std::vector<AtlasCause>& causes, const std::string& name) {
  return std::ranges::find(causes, name, &AtlasCause::Name) != causes.end();
}

constexpr const char* kHeights = "tz_grid: {grid: [3, 3]}}, {tz_heights: {heights: 5}";

TEST(TripleZAtlas, AFixedPostTellsAScrewFromAGantryThatLeans) {
  const Atlas without = AtlasFor(Planned(std::string("[{") + kHeights + "}]"));
  const Atlas with = AtlasFor(
      Planned(std::string("[{") + kHeights + "}, {fixed_post: {heights: 5}}]"));

  EXPECT_TRUE(AreConfounded(without, "screw_pitch.z3", "angular.EAZ"));
  EXPECT_TRUE(AreConfounded(without, "screw_pitch.z2", "angular.EBZ"));
  EXPECT_FALSE(AreConfounded(with, "screw_pitch.z3", "angular.EAZ"));
  EXPECT_FALSE(AreConfounded(with, "screw_pitch.z2", "angular.EBZ"));
  EXPECT_TRUE(IsIn(with.visible, "screw_pitch.z3"));
}

TEST(TripleZAtlas, OnlySingleScrewsShowPivotsAndWiring) {
  const Atlas without = AtlasFor(Planned("[{tz_grid: {grid: [3, 3]}}]"));
  const Atlas with =
      AtlasFor(Planned("[{tz_grid: {grid: [3, 3]}}, {screws_one_by_one: {}}]"));

  for (const char* name :
       {"pivot_position.z2", "motors_swapped.z1z3", "overconstrained_bed"}) {
    EXPECT_FALSE(IsIn(without.visible, name)) << name;
    EXPECT_TRUE(IsIn(with.visible, name)) << name;
  }
}

// Each homing stands the bed anew.
TEST(TripleZAtlas, TheBaselineHasAPlaneForEachHoming) {
  const Machine machine = ReadMachine("models/triple_z_printer/machine.yaml");
  PlannedSession session = PlanSession(
      ReadPlanText("campaigns: [tz_grid: {grid: [3, 3]}]", "plan.yaml"), machine, 1);
  for (std::size_t i = 0; i < session.rows.size(); ++i) {
    session.rows[i].home = i % 2 == 0 ? "1" : "2";
  }
  const Observed observed(
      {.rows = std::move(session.rows)}, std::move(session.header), machine, {});

  std::vector<std::string> names;
  for (const Nuisance& line : BaselineOf(observed)) names.push_back(line.name);

  EXPECT_THAT(names,
              ::testing::IsSupersetOf({"bed_plane.1.slope_x",
                                       "bed_plane.2.slope_y",
                                       "bed_plane.2.height",
                                       "scale.z",
                                       "backlash.z"}));
}

}  // namespace
}  // namespace caltwin

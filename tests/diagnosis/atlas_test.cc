#include "calibration/diagnosis/atlas.h"

#include <algorithm>
#include <string>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace caltwin {
namespace {

using ::testing::HasSubstr;

Machine Gantry() {
  return ReadMachine("models/gantry_router/machine.yaml");
}

Observed Planned(const std::string& campaigns, double load_n = kUnknown) {
  const Machine machine = Gantry();
  PlannedSession session =
      PlanSession(ReadPlanText("campaigns: " + campaigns, "plan.yaml"), machine, 1);
  for (Row& row : session.rows) {
    if (Known(load_n)) row.load_n = load_n;
  }
  return {{.rows = std::move(session.rows)}, std::move(session.header), machine, {}};
}

Atlas AtlasFor(const Observed& observed) {
  std::vector<Candidate> candidates = AllCandidates(observed);
  std::erase_if(candidates, [](const Candidate& one) { return one.is_free(); });
  return AtlasOf(observed, candidates, PlannedSigma_mm(observed));
}

const AtlasCause* Find(const std::vector<AtlasCause>& causes, const std::string& name) {
  const auto found = std::ranges::find(causes, name, &AtlasCause::Name);
  return found == causes.end() ? nullptr : &*found;
}

bool AreConfounded(const Atlas& atlas, const std::string& a, const std::string& b) {
  return std::ranges::any_of(atlas.confounded, [&](const ConfoundedPair& pair) {
    return std::pair(pair.first.Name(), pair.second.Name()) == std::pair(a, b) ||
           std::pair(pair.first.Name(), pair.second.Name()) == std::pair(b, a);
  });
}

TEST(Atlas, NeedsATurnedPlateToTellSagFromACurvedBed) {
  const Atlas alone = AtlasFor(Planned("[plate: {grid: [5, 5], repeats: 1}]"));
  const Atlas turned = AtlasFor(Planned(
      "[plate: {grid: [5, 5], repeats: 1}, plate_turned_90: {grid: [5, 5], repeats: "
      "1}]"));

  EXPECT_TRUE(AreConfounded(alone, "gantry_sag", "bed_cylinder.x"));
  EXPECT_FALSE(AreConfounded(turned, "gantry_sag", "bed_cylinder.x"));
  EXPECT_NE(Find(turned.visible, "gantry_sag"), nullptr);
  EXPECT_NE(Find(turned.visible, "bed_cylinder.x"), nullptr);
}

TEST(Atlas, OneFeedHidesATriggerLatencyInThePretravel) {
  const Atlas one = AtlasFor(Planned("[blocks: {feeds_mm_s: [1]}]"));
  const Atlas three = AtlasFor(Planned("[blocks: {feeds_mm_s: [1, 3, 9]}]"));

  const AtlasCause* absorbed = Find(one.absorbed, "trigger_latency");
  ASSERT_NE(absorbed, nullptr);
  EXPECT_THAT(absorbed->into, HasSubstr("probe_pretravel"));
  EXPECT_NE(Find(three.visible, "trigger_latency"), nullptr);
}

TEST(Atlas, OneLoadHidesWindUpInBacklash) {
  const Atlas one = AtlasFor(Planned("[iso230]", /*load_n=*/20));
  const Atlas two = AtlasFor(Planned("[iso230: {loads_n: [0, 50]}]"));

  const AtlasCause* absorbed = Find(one.absorbed, "windup_load.x");
  ASSERT_NE(absorbed, nullptr);
  EXPECT_THAT(absorbed->into, HasSubstr("backlash.x"));
  EXPECT_NE(Find(two.visible, "windup_load.x"), nullptr);
}

TEST(Atlas, TargetsAtWholeTurnsHideTheScrewsWave) {
  // 280 mm in 14 steps of 20 mm: five turns of the screw each.
  const Atlas regular = AtlasFor(
      Planned("[iso230: {positions: 15, margin_mm: 10, runs: 1, regular: true}]"));
  const Atlas random =
      AtlasFor(Planned("[iso230: {positions: 15, margin_mm: 10, runs: 1}]"));

  EXPECT_EQ(Find(regular.visible, "cyclic_lead.x"), nullptr);
  EXPECT_NE(Find(random.visible, "cyclic_lead.x"), nullptr);
}

TEST(Atlas, ACauseThatNoReadingMeetsIsUnseen) {
  const Atlas laser = AtlasFor(Planned("[iso230: {runs: 1}]"));

  EXPECT_NE(Find(laser.unseen, "probe_lobing"), nullptr);
  EXPECT_EQ(Find(laser.visible, "probe_lobing"), nullptr);
}

}  // namespace
}  // namespace caltwin

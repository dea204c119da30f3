#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/procedures/cluster_backlash.h"
#include "calibration/procedures/release_backlash.h"
#include "tests/calibration/toy_bench.h"

namespace caltwin {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::RunStep;
using testing::ToyBench;

// Trigger and release are each off by half a motor step at most; the slow feed counts
// 1.25 times in the extrapolation, the fast one 0.25 times.
constexpr double kFromRounding_mm = (1.25 + 0.25) / 800;

TEST(TriggerRelease, FindsTheGapAndSetsIt) {
  ToyBench toy;
  toy.machine.drives[0] = {.gap_mm = 0.05, .pretravel_mm = 0.03};
  toy.machine.latency_s = 0.002;

  const ProcedureResult result = RunStep(kTriggerReleaseBacklash, "{axis: x}", &toy);

  EXPECT_EQ(result.ending, Ending::kDone);
  EXPECT_NEAR(toy.machine.settings.backlash_mm[0], 0.05, kFromRounding_mm);
  ASSERT_EQ(result.estimates.size(), 1u);
  EXPECT_TRUE(result.estimates[0].is_setting);
}

// The counter's millimetres are 1 % too long: so is the gap. Who has measured steps/mm
// need not allow for that.
TEST(TriggerRelease, AllowsForStepsThatNobodyHasMeasured) {
  ToyBench toy, measured;
  for (ToyBench* one : {&toy, &measured}) one->machine.drives[0].gap_mm = 0.4;
  toy.machine.settings.steps_per_mm[0] = 808;
  measured.bench.ledger.known["steps_per_mm.x"] = {
      .value = 800, .sd = 0.008, .identifiable = true};

  const ProcedureResult doubtful = RunStep(kTriggerReleaseBacklash, "{axis: x}", &toy);
  const ProcedureResult sure = RunStep(kTriggerReleaseBacklash, "{axis: x}", &measured);

  ASSERT_EQ(doubtful.estimates.size(), 1u);
  ASSERT_EQ(sure.estimates.size(), 1u);
  const double off_mm = doubtful.estimates[0].value - 0.4;
  EXPECT_GT(std::abs(off_mm), 0.003);
  EXPECT_LT(std::abs(off_mm), 1.96 * doubtful.estimates[0].sd);
  EXPECT_LT(sure.estimates[0].sd, 0.002);
}

TEST(TriggerRelease, SaysBeforehandThatItTellsTheGap) {
  ToyBench toy;

  const ProcedureResult result = RunStep(kTriggerReleaseBacklash, "{axis: x}", &toy);

  EXPECT_THAT(result.messages.at(0), HasSubstr("The plan determines backlash.x"));
  ASSERT_FALSE(result.observability.empty());
  EXPECT_EQ(result.observability[0].statement, "probe_pretravel.x - tip_size only");
}

TEST(TriggerRelease, TwoRunsGiveTheSame) {
  ToyBench toy;
  toy.machine.drives[1].gap_mm = 0.08;

  RunStep(kTriggerReleaseBacklash, "{axis: y}", &toy);
  const double first_mm = toy.machine.settings.backlash_mm[1];
  RunStep(kTriggerReleaseBacklash, "{axis: y}", &toy);

  EXPECT_EQ(toy.machine.settings.backlash_mm[1], first_mm);
  EXPECT_NEAR(first_mm, 0.08, kFromRounding_mm);
}

TEST(TriggerRelease, TurnsCompensationOffAndBackOn) {
  ToyBench toy;
  toy.machine.drives[0].gap_mm = 0.05;
  toy.machine.settings.backlash_mm[0] = 0.03;
  toy.machine.confirms = false;

  RunStep(kTriggerReleaseBacklash, "{axis: x}", &toy);

  std::vector<std::string> written;
  std::ranges::copy_if(toy.machine.log, std::back_inserter(written), [](auto& line) {
    return line.starts_with("M425 ");
  });
  EXPECT_THAT(written, ElementsAre("M425 X0", "M425 X0.03"));
}

TEST(TriggerRelease, RestoresCompensationAfterAFault) {
  ToyBench toy;
  toy.machine.settings.backlash_mm[0] = 0.03;
  toy.machine.artefacts[0].at_mm = {20, 20, 0};  // Not where the papers say.

  const ProcedureResult result = RunStep(kTriggerReleaseBacklash, "{axis: x}", &toy);

  EXPECT_EQ(result.ending, Ending::kNoTrigger);
  EXPECT_EQ(toy.machine.settings.backlash_mm[0], 0.03);
}

TEST(TriggerRelease, SaysWhereTheCarriageGivesWay) {
  ToyBench toy;
  toy.bench.machine.axes[0].rail_friction_n = 0.1;
  toy.machine.drives[0].gap_mm = 0.05;

  const ProcedureResult result = RunStep(kTriggerReleaseBacklash, "{axis: x}", &toy);

  EXPECT_EQ(result.ending, Ending::kConfounded);
  EXPECT_FALSE(result.estimates[0].identifiable);
  EXPECT_EQ(toy.machine.settings.backlash_mm[0], 0);
  EXPECT_THAT(result.messages, Contains(HasSubstr("hysteresis alone")));
}

TEST(ClusterBacklash, AsPublishedStartsInsideTheSolidBlock) {
  for (const char* macro : {"", ", macro: G9100"}) {
    ToyBench toy;

    const ProcedureResult result =
        RunStep(kClusterBacklash,
                std::string("{axis: x, variant: as_published") + macro + "}",
                &toy);

    EXPECT_EQ(result.ending, Ending::kCollision);
  }
}

TEST(ClusterBacklash, AsPublishedReadsTheThicknessOfAWeb) {
  ToyBench toy;
  const Artefact web{.id = "web",
                     .type = ArtefactType::kWeb,
                     .at_mm = {150, 150, 0},
                     .size_mm = {10, 60, 30}};
  toy.machine.artefacts = toy.bench.artefacts = {web};
  toy.machine.drives[0] = {.gap_mm = 0.05, .pretravel_mm = 0.02};

  const ProcedureResult result =
      RunStep(kClusterBacklash, "{axis: x, variant: as_published, apply: false}", &toy);

  EXPECT_NEAR(result.estimates[0].value, 10 - (2 * 0.02 + 0.05), 2 / 800.0);
  EXPECT_THAT(result.messages, Contains(HasSubstr("block's dimensions")));
}

TEST(ClusterBacklash, CorrectedPrintsItsClustersAndFindsTheGap) {
  ToyBench toy;
  toy.machine.drives[0].gap_mm = 0.05;

  const ProcedureResult result = RunStep(kClusterBacklash, "{axis: x}", &toy);

  EXPECT_NEAR(toy.machine.settings.backlash_mm[0], 0.05, kFromRounding_mm);
  EXPECT_THAT(result.messages, Contains(HasSubstr("20 triggers")));
  EXPECT_THAT(result.messages, Contains(HasSubstr("one cluster")));
}

}  // namespace
}  // namespace caltwin

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/procedures/dual_dimension.h"
#include "tests/calibration/toy_bench.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;
using testing::RunStep;
using testing::ToyBench;

// Half a motor step on each of four faces, over the difference of the sizes.
constexpr double kStepsFromRounding = 800 * (2 / 800.0) / 50.8;

TEST(DualDimension, CorrectedFindsTheTrueStepsInOnePass) {
  ToyBench toy;
  toy.machine.settings.steps_per_mm[0] = 808;
  toy.machine.drives[0] = {.true_steps_per_mm = 800, .gap_mm = 0.05};

  const ProcedureResult result =
      RunStep(kDualDimension, "{axis: x, variant: corrected}", &toy);

  EXPECT_EQ(result.ending, Ending::kDone);
  EXPECT_NEAR(toy.machine.settings.steps_per_mm[0], 800, kStepsFromRounding);
  ASSERT_EQ(result.estimates.size(), 1u);
  EXPECT_TRUE(result.estimates[0].is_setting);
}

TEST(DualDimension, AsPublishedDoublesTheErrorUntilTheLimitStopsIt) {
  ToyBench toy;
  toy.machine.settings.steps_per_mm[0] = 808;

  const ProcedureResult result =
      RunStep(kDualDimension, "{axis: x, variant: as_published, iterations: 6}", &toy);

  ASSERT_EQ(result.steps.size(), 4u);
  double expected = 808;
  for (int pass = 0; pass < 3; ++pass) {
    expected = expected * expected / 800;
    EXPECT_NEAR(result.steps[pass].after, expected, 10 * kStepsFromRounding);
    EXPECT_EQ(result.steps[pass].verdict, Verdict::kApplied);
  }
  EXPECT_EQ(result.steps[3].verdict, Verdict::kRefused);
  EXPECT_EQ(result.steps[3].after, result.steps[2].after);
}

TEST(DualDimension, SaysThatItSeesOnlyTheSumOfPretravelBacklashAndTip) {
  ToyBench toy;

  const ProcedureResult result = RunStep(kDualDimension, "{axis: x}", &toy);

  ASSERT_FALSE(result.observability.empty());
  EXPECT_EQ(result.observability[0].statement,
            "probe_pretravel.x + backlash.x / 2 - tip_size only");
}

TEST(DualDimension, MacroG9000AimsBesideTheFaceAndFindsNothing) {
  ToyBench toy;

  const ProcedureResult result =
      RunStep(kDualDimension, "{axis: x, variant: as_published, macro: G9000}", &toy);

  EXPECT_EQ(result.ending, Ending::kNoTrigger);
  EXPECT_THAT(result.messages.back(), HasSubstr("target lies beyond"));
}

TEST(DualDimension, AppliesNothingThatIsNotConfirmed) {
  ToyBench toy;
  toy.machine.settings.steps_per_mm[1] = 808;
  toy.machine.confirms = false;

  const ProcedureResult result = RunStep(kDualDimension, "{axis: y}", &toy);

  EXPECT_EQ(result.ending, Ending::kRefused);
  EXPECT_EQ(toy.machine.settings.steps_per_mm[1], 808);
  EXPECT_FALSE(result.estimates[0].is_setting);
  EXPECT_NEAR(result.estimates[0].value, 800, kStepsFromRounding);
}

}  // namespace
}  // namespace caltwin

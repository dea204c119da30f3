#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/procedures/dial_backlash.h"
#include "calibration/procedures/rough_steps.h"
#include "calibration/procedures/uninformative_backlash.h"
#include "tests/calibration/toy_bench.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;
using testing::RunStep;
using testing::ToyBench;

constexpr double kStep_mm = 1 / 800.0;

TEST(DialBacklash, RecoversTheGapOfEveryAxis) {
  for (const char axis : {'x', 'y', 'z'}) {
    ToyBench toy;
    const auto i = static_cast<std::size_t>(axis - 'x');
    toy.machine.drives[i].gap_mm = 0.05;

    const ProcedureResult result =
        RunStep(kDialBacklash, fmt::format("{{axis: {}}}", axis), &toy);

    EXPECT_EQ(result.ending, Ending::kDone);
    EXPECT_NEAR(toy.machine.settings.backlash_mm[i], 0.05, kStep_mm) << axis;
  }
}

TEST(DialBacklash, ASecondRunFindsNothingLeft) {
  ToyBench toy;
  toy.machine.drives[0].gap_mm = 0.05;

  RunStep(kDialBacklash, "{axis: x}", &toy);
  const double first_mm = toy.machine.settings.backlash_mm[0];
  RunStep(kDialBacklash, "{axis: x}", &toy);

  EXPECT_NEAR(toy.machine.settings.backlash_mm[0], first_mm, kStep_mm);
}

TEST(UninformativeBacklash, ReadsZeroForEveryGap) {
  for (const double gap_mm : {0.0, 0.05, 0.20}) {
    for (const Procedure& procedure : {kSameSideBacklash, kAwayReturnBacklash}) {
      ToyBench toy;
      toy.machine.drives[0].gap_mm = gap_mm;

      const ProcedureResult result = RunStep(procedure, "{axis: x}", &toy);

      EXPECT_EQ(result.ending, Ending::kReadsZero) << procedure.name;
      EXPECT_FALSE(result.estimates.at(0).identifiable);
      EXPECT_EQ(toy.machine.settings.backlash_mm[0], 0);
      EXPECT_THAT(result.steps.at(0).message, HasSubstr("Reads 0.0000 mm"));
    }
  }
}

TEST(UninformativeBacklash, CorrectedFindsTheGap) {
  for (const Procedure& procedure : {kSameSideBacklash, kAwayReturnBacklash}) {
    ToyBench toy;
    toy.machine.drives[0].gap_mm = 0.05;

    RunStep(procedure, "{axis: x, variant: corrected}", &toy);

    EXPECT_NEAR(toy.machine.settings.backlash_mm[0], 0.05, 1.5 * kStep_mm);
  }
}

TEST(RoughSteps, FindsTheTrueStepsWhateverTheGap) {
  ToyBench toy;
  toy.machine.settings.steps_per_mm[0] = 824;
  toy.machine.drives[0].gap_mm = 0.1;

  const ProcedureResult result = RunStep(kRoughSteps, "{axis: x}", &toy);

  const double from_rounding = 800 * kStep_mm / 100;
  EXPECT_EQ(result.ending, Ending::kDone);
  EXPECT_NEAR(toy.machine.settings.steps_per_mm[0], 800, from_rounding);
}

TEST(RoughSteps, RefusesMoreThanFivePercent) {
  ToyBench toy;
  toy.machine.settings.steps_per_mm[0] = 850;

  const ProcedureResult result = RunStep(kRoughSteps, "{axis: x}", &toy);

  EXPECT_EQ(result.ending, Ending::kRefused);
  EXPECT_EQ(toy.machine.settings.steps_per_mm[0], 850);
}

}  // namespace
}  // namespace caltwin

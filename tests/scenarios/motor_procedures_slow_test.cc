#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "calibration/motor_axes/procedures.h"
#include "tests/scenarios/motor_bench.h"

namespace caltwin {
namespace {

// The stated uncertainty is the scatter of repeats, and covers the truth.
TEST(MotorBacklash, CorrectedRecoversTheGapWithItsUncertainty) {
  constexpr double kGap_mm = 0.05;
  constexpr int kRepeats = 12;
  double squares = 0;
  for (int i = 0; i < kRepeats; ++i) {
    BuiltMotorStage built = BuiltAsDrawn(DrawnMotorStage());
    built.motors[0].gap_unit = kGap_mm;
    MotorBenchInATest bench(built, /*is_physics=*/false, 1, i);
    bench.axes.SetZero(0, 0);
    const MotorResult read = RunMotorBacklash(&bench.axes, {.axes = {0}});
    const Estimate& gap = read.result.estimates.at(0);
    squares += std::pow((gap.value - kGap_mm) / gap.sd, 2);
  }

  // chi-squared of 12: between these with 99.9 %.
  EXPECT_GT(squares, 2.2);
  EXPECT_LT(squares, 32.9);
}

// Nearly at the index or just beyond it: as often one pulse as none or two.
TEST(IndexVerify, AsPublishedCountsNoneOneOrTwoCorrectedAlwaysOne) {
  std::array<int, 4> published{}, corrected{};
  for (int i = 0; i < 40; ++i) {
    BuiltMotorStage built = BuiltAsDrawn(DrawnMotorStage());
    built.faults[0].start_unit = -5;
    MotorBenchInATest bench(built, /*is_physics=*/false, 1, i);
    RunServoHome(&bench.axes, {.axes = {0}});
    const auto count = [&](bool is_as_published) {
      const MotorOptions o{
          .is_as_published = is_as_published, .axes = {0}, .retries = 0};
      return RunIndexVerify(&bench.axes, o).found.index_edges.value();
    };
    ++corrected.at(count(false));
    bench.axes.SetField(203, 0, 250);
    ++published.at(count(true));
  }

  EXPECT_EQ(corrected[1], 40);
  EXPECT_GT(published[0] + published[2], 5);
  EXPECT_GT(published[1], 5);
}

}  // namespace
}  // namespace caltwin

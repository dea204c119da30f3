#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include <gtest/gtest.h>

#include "calibration/estimate/touch_noise.h"
#include "calibration/kinds/motor_stage/procedures.h"
#include "tests/scenarios/motor_bench.h"

namespace caltwin {
namespace {

/// How far the first estimate of each of so many stages is from the truth, in its own
/// standard deviations: chi-squared of as many.
double SquaresOf(int stages,
                 const BuiltMotorStage& built,
                 const std::function<MotorResult(MotorAxes*)>& measure,
                 double truth) {
  double squares = 0;
  for (int i = 0; i < stages; ++i) {
    MotorBenchInATest bench(built, /*is_physics=*/false, 1, i);
    bench.axes.SetZero(0, 0);
    bench.axes.SetZero(1, 0);
    const MotorResult read = measure(&bench.axes);
    const Estimate& estimate = read.result.estimates.at(0);
    squares += std::pow((estimate.value - truth) / estimate.sd, 2);
  }
  return squares;
}

// The stated uncertainty is the scatter of repeats, and covers the truth.
TEST(MotorBacklash, CorrectedRecoversTheGapWithItsUncertainty) {
  constexpr double kGap_mm = 0.05;
  BuiltMotorStage built = BuiltAsDrawn(DrawnMotorStage());
  built.motors[0].gap_unit = kGap_mm;

  const double squares = SquaresOf(
      12,
      built,
      [](MotorAxes* axes) { return RunMotorBacklash(axes, {.axes = {0}}); },
      kGap_mm);

  // chi-squared of 12: between these with 99.9 %.
  EXPECT_GT(squares, 2.2);
  EXPECT_LT(squares, 32.9);
}

/// A laser that somebody bumps: from that reading on it stands elsewhere.
class BumpedGauge : public Gauge {
 public:
  BumpedGauge(Gauge* inner, int at_reading) : inner_(inner), left_(at_reading) {}
  Expected<double> Read_mm(std::string_view id) override {
    constexpr double kBump_mm = 0.5;
    auto read_mm = inner_->Read_mm(id);
    if (read_mm && left_-- <= 0) *read_mm += kBump_mm;
    return read_mm;
  }
  Expected<void> Zero(std::string_view id) override { return inner_->Zero(id); }

 private:
  Gauge* inner_;
  int left_;
};

// Between the two senses of one approach of the check: the gap itself was measured
// well.
TEST(MotorBacklash, ACheckThatFailsTakesTheCompensationBack) {
  constexpr double kBefore_mm = 0.01;
  constexpr int kReadings = 2 * MotorOptions{}.repeats;
  BuiltMotorStage built = BuiltAsDrawn(DrawnMotorStage());
  built.motors[0].gap_unit = 0.05;
  MotorBenchInATest bench(built);
  BumpedGauge bumped(&bench.gauge, kReadings + 1);
  MotorAxes axes({.link = &bench.arming, .gauge = &bumped, .drawing = built.drawing});
  axes.SetZero(0, 0);
  axes.SetField(425, 0, kBefore_mm);

  const MotorResult read = RunMotorBacklash(&axes, {.axes = {0}});

  EXPECT_EQ(*axes.Field(425, 0), kBefore_mm);
  EXPECT_EQ(read.found.warnings, 1);
  ASSERT_FALSE(read.result.steps.empty());
  EXPECT_EQ(read.result.steps.back().verdict, Verdict::kRolledBack);
}

// A switch that scatters twice as much as drawn is seldom proven to by five looks, but
// what they show counts: the stated uncertainty is that of where homes lie.
TEST(StepperHome, UncertaintyIsThatOfASwitchTwiceAsBadAsDrawn) {
  constexpr std::size_t kU = 4;
  constexpr int kHomings = 60;
  std::vector<double> homes_mm;
  double variance_mm2 = 0;
  for (int i = 0; i < kHomings; ++i) {
    BuiltMotorStage built = BuiltAsDrawn(DrawnMotorStage());
    built.faults[kU].switch_scatter_unit =
        2 * built.drawing.axes[kU].switch_scatter_unit;
    MotorBenchInATest bench(built, /*is_physics=*/false, 1, i);
    const MotorResult homed = RunStepperHome(&bench.axes, {.axes = {kU}});
    variance_mm2 += std::pow(homed.result.estimates.at(0).sd, 2) / kHomings;
    homes_mm.push_back(TrueHome(bench.firmware, bench.rig, kU));
  }

  const double squares_mm2 = (kHomings - 1) * std::pow(Scatter(homes_mm), 2);
  // chi-squared of 59: between these with 99.9 %.
  EXPECT_GT(squares_mm2 / variance_mm2, 29.6);
  EXPECT_LT(squares_mm2 / variance_mm2, 100.3);
}

// Of a move too short for its speed: the counters pass half the way more slowly.
TEST(AxisSync, UncertaintyOfAShortMoveIsThatOfTheSpeedItGetsTo) {
  constexpr double kDelay_s = 0.0007;
  BuiltMotorStage built = BuiltAsDrawn(DrawnMotorStage());
  built.faults[1].start_delay_s = kDelay_s;

  const double squares = SquaresOf(
      40,
      built,
      [](MotorAxes* axes) {
        return RunAxisSync(axes, {.axes = {0, 1}, .distance_unit = 0.5});
      },
      kDelay_s);

  // chi-squared of 40: between these with 99.9 %.
  EXPECT_GT(squares, 16.9);
  EXPECT_LT(squares, 76.1);
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

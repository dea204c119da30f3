#include "scenarios/motor_scenario.h"

#include <array>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenarios/runner.h"
#include "tests/scenarios/motor_bench.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;

const std::filesystem::path kName = CALTWIN_SOURCE_DIR "/scenarios/in_a_test.yaml";

Scenario ReadText(const std::string& keys) {
  return ReadScenarioText("machine: motor_stage\nfidelity: fast\n" + keys, kName);
}

std::string FaultOf(const std::string& keys) {
  try {
    ReadText(keys);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(MotorScenario, NamesWhatItCannotDo) {
  EXPECT_THAT(FaultOf("calibrate: [{servo_home: {axis: u}}]\n"),
              HasSubstr("u is an open-loop stepper: servo_home needs a servo"));
  EXPECT_THAT(FaultOf("calibrate: [{stepper_home: {axis: x}}]\n"),
              HasSubstr("x is a servo: servo_home homes it"));
  EXPECT_THAT(FaultOf("calibrate: [bed_tilt]\n"),
              HasSubstr("'bed_tilt' is no procedure of a motor stage\n  there are "
                        "servo_home, index_verify"));
  EXPECT_THAT(FaultOf("calibrate: [servo_home]\n"), HasSubstr("axis"));
  EXPECT_THAT(FaultOf("effects: {backlsh.x: {gap_mm: 0.1}}\n"
                      "calibrate: [{servo_home: {axis: x}}]\n"),
              HasSubstr("did you mean 'backlash'?"));
  EXPECT_THAT(FaultOf("effects: {backlash.a: {gap_mm: 0.1}}\n"
                      "calibrate: [{servo_home: {axis: a}}]\n"),
              HasSubstr("gap_deg"));
  EXPECT_THAT(FaultOf("effects: {start_delay.u: {delay_ms: 1}}\n"
                      "calibrate: [{stepper_home: {axis: u}}]\n"),
              HasSubstr("is of servos; u is an open-loop stepper"));
  EXPECT_THAT(FaultOf("effects: {obstacle.x: {}}\n"
                      "calibrate: [{servo_home: {axis: x}}]\n"),
              HasSubstr("changes nothing"));
}

TEST(MotorScenario, DrawsNumbersFromDistributionsAlikeForOneSeed) {
  const Scenario scenario = ReadText(
      "effects: {backlash.x: {gap_mm: {uniform: {min: 0.01, max: 0.1}}}}\n"
      "calibrate: [{servo_home: {axis: x}}]\n");

  const auto gap_mm = [&](std::uint64_t sample) {
    return DrawMotorStage(*scenario.motor, 1, sample).motors[0].gap_unit;
  };
  EXPECT_EQ(gap_mm(0), gap_mm(0));
  EXPECT_NE(gap_mm(0), gap_mm(1));
  EXPECT_GE(gap_mm(0), 0.01);
}

TEST(MotorScenario, AnObstacleLiesOnItsSideOfTheStart) {
  const auto built = [](const std::string& at) {
    return DrawMotorStage(*ReadText("effects: {obstacle.x: {at_mm: " + at +
                                    "}, start.x: {at_mm: 60}}\n"
                                    "calibrate: [{servo_home: {axis: x}}]\n")
                               .motor,
                          1,
                          0);
  };

  EXPECT_EQ(built("20").motors[0].low_obstacle_unit, 20);
  EXPECT_FALSE(built("20").motors[0].high_obstacle_unit);
  EXPECT_EQ(built("70").motors[0].high_obstacle_unit, 70);
}

// Every gap from nothing to a tenth: the counter's answer is the commanded 10 mm.
TEST(MotorBacklash, AsPublishedIsTheDistanceForAnyGap) {
  for (const double gap_mm : {0.0, 0.02, 0.1}) {
    BuiltMotorStage built = BuiltAsDrawn(DrawnMotorStage());
    built.motors[0].gap_unit = gap_mm;
    MotorBenchInATest bench(built);
    bench.axes.SetZero(0, 0);

    const MotorResult read =
        RunMotorBacklash(&bench.axes, {.is_as_published = true, .axes = {0}});

    EXPECT_NEAR(read.result.estimates.at(0).value, 10, 0.0021) << gap_mm;
  }
}

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

TEST(ServoHome, WarnsOfAnIndexWithinReachAndNotOfOneFarOff) {
  for (const auto& [index_mm, warnings] : {std::pair(2.02, 1), std::pair(6.3, 0)}) {
    BuiltMotorStage built = BuiltAsDrawn(DrawnMotorStage());
    built.faults[0].start_unit = -5;
    built.motors[0].drawing.index_from_switch_unit = index_mm;
    MotorBenchInATest bench(built);

    const MotorResult homed = RunServoHome(&bench.axes, {.axes = {0}});

    EXPECT_EQ(homed.found.warnings, warnings) << index_mm;
    EXPECT_EQ(*homed.found.wrong_turn_probability > 1e-6, warnings == 1) << index_mm;
  }
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

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/kinds/motor_stage/doing.h"
#include "scenarios/kinds/motor_stage_scenario.h"
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
  EXPECT_THAT(
      FaultOf("calibrate: [bed_tilt]\n"),
      HasSubstr(
          "is a procedure of a triple-Z printer, not of a motor stage\n  there are "
          "servo_home, index_verify"));
  EXPECT_THAT(FaultOf("calibrate: [servo_home]\n"), HasSubstr("axis"));
  EXPECT_THAT(FaultOf("calibrate: [{emergency_stop: {axes: [y, y]}}]\n"),
              HasSubstr("is named twice"));
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

// What lies beyond the drawing can stand there or be gone to by nobody.
TEST(MotorScenario, RefusesWhatIsBeyondTheDrawing) {
  const auto fault_of_effect = [](const std::string& effect) {
    return FaultOf("effects: {" + effect + "}\ncalibrate: [{servo_home: {axis: x}}]\n");
  };
  const auto fault_of_step = [](const std::string& step) {
    return FaultOf("calibrate: [{" + step + "}]\n");
  };

  EXPECT_THAT(fault_of_effect("start.x: {at_mm: 213}"), HasSubstr("-12"));
  EXPECT_EQ(fault_of_effect("start.x: {at_mm: 211}"), "");
  EXPECT_THAT(fault_of_effect("obstacle.x: {at_mm: -13}"), HasSubstr("-12"));
  EXPECT_THAT(fault_of_effect("load.x: {added_kg: -12}"), HasSubstr("-12"));
  EXPECT_EQ(fault_of_effect("load.x: {added_kg: -11}"), "");
  EXPECT_THAT(fault_of_effect("pulse_loss.x: {above_mm_s: 50}"),
              HasSubstr("loses no pulse"));
  EXPECT_THAT(fault_of_effect("index_position.x: {from_switch_mm: 10.1}"),
              HasSubstr("10"));
  EXPECT_THAT(fault_of_step("stepper_home: {axis: u, safe_mm: 101}"), HasSubstr("100"));
  EXPECT_THAT(fault_of_step("stepper_home: {axis: u, fine_mm_s: 61}"), HasSubstr("60"));
  EXPECT_THAT(fault_of_step("travel_limits: {axis: u, margin_mm: 51}"),
              HasSubstr("50"));
  EXPECT_THAT(fault_of_step("axis_sync: {axes: [x, z], distance_mm: 121}"),
              HasSubstr("60"));
}

// A line that the controller does not know is refused, not lost with the power.
TEST(MotorScenario, AnUnknownLineBeforeAPowerCutIsRefused) {
  const RunResult result =
      RunScenario(ReadText("calibrate: [{power_cut: {lines: [\"M4711\"]}}]\n"), {});

  EXPECT_EQ(result.outcome, "refused");
}

// An option that a procedure does not heed would be ignored in silence.
TEST(MotorScenario, OptionsThatAProcedureDoesNotHeedAreRefused) {
  for (const char* step : {"servo_home: {axis: x, tolerance_mm: 1}",
                           "motor_backlash: {axis: x, touches: 3}",
                           "index_verify: {axis: x, repeats: 3}",
                           "emergency_stop: {axes: [x], margin_mm: 3}",
                           "emergency_stop: {axes: [x], variant: as_published}",
                           "power_cut: {axis: x}"}) {
    EXPECT_THAT(FaultOf("calibrate: [{" + std::string(step) + "}]\n"),
                HasSubstr("has no key"))
        << step;
  }
}

// 128 bytes a record: cut before its last byte the old one counts, after it the new.
TEST(MotorScenario, APowerCutLeavesTheOldRecordOrTheNew) {
  for (const auto& [bytes, home] : {std::pair("0", "M206 X: X:0"),
                                    std::pair("127", "M206 X: X:0"),
                                    std::pair("128", "M206 X: X:77"),
                                    std::pair("500", "M206 X: X:77")}) {
    const RunResult result = RunScenario(
        ReadText("calibrate: [{gcode: {lines: [\"M500 X\", \"M206 X77\"]}}, "
                 "{power_cut: {lines: [\"M500 X\"], after_bytes: " +
                 std::string(bytes) + "}}, {gcode: {lines: [\"M206 X\"]}}]\n"),
        {});
    EXPECT_EQ(result.messages.back().text, home) << bytes;
  }
}

// It closes where it is passed and opens 0.05 mm later: a short step back leaves it
// closed. Seen at 0.5 mm/s it is passed by less than 0.01 mm.
TEST(LimitSwitch, OpensItsHysteresisLater) {
  BuiltMotorStage built = BuiltAsDrawn(DrawnMotorStage());
  built.faults[0].start_unit = -7;
  MotorBenchInATest bench(built);
  ASSERT_TRUE(bench.axes.SeekSwitch(0, -3, 0.5));
  const auto after = [&](double back_mm) {
    EXPECT_TRUE(bench.axes.MoveBy(0, back_mm, 0.5));
    return bench.axes.IsPressed(0, /*is_min=*/true).value();
  };

  EXPECT_TRUE(after(0.03));
  EXPECT_FALSE(after(0.04));
}

// v M / (F + friction), of the mass that is there.
TEST(EmergencyStop, ForetellsAndThenSeesAnUnknownLoad) {
  constexpr double kSpeed_mm_s = 250, kExact_s = 0.00001;
  for (const bool is_physics : {false, true}) {
    for (const auto& [load_kg, warnings] : {std::pair(0.0, 0), std::pair(40.0, 2)}) {
      BuiltMotorStage built = BuiltAsDrawn(DrawnMotorStage());
      MotorAxisDrawing& x = built.motors[0].drawing;
      x.load_inertia += load_kg;
      built.faults[0].start_unit = 20;
      MotorBenchInATest bench(built, is_physics);
      bench.axes.SetZero(0, 0);

      const MotorResult stopped =
          RunEmergencyStop(&bench.axes, {.axes = {0}, .medium = 1});

      EXPECT_EQ(stopped.found.warnings, warnings) << stopped.result.fault;
      EXPECT_TRUE(*stopped.found.stop_feasible);
      EXPECT_EQ(*stopped.found.stopped_within, load_kg == 0);
      const double braked_s = kSpeed_mm_s * x.si_per_unit() * x.total_inertia() /
                              (x.largest_force() + x.friction);
      EXPECT_NEAR(*stopped.found.standstill_s, 0.0005 + braked_s, kExact_s);
    }
  }
}

TEST(MotorScenario, DrawsNumbersFromDistributionsAlikeForOneSeed) {
  const Scenario scenario = ReadText(
      "effects: {backlash.x: {gap_mm: {uniform: {min: 0.01, max: 0.1}}}}\n"
      "calibrate: [{servo_home: {axis: x}}]\n");

  const auto gap_mm = [&](std::uint64_t sample) {
    return DrawMotorStage(*scenario.kind.As<MotorStageScenario>(), 1, sample)
        .motors[0]
        .gap_unit;
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
                               .kind.As<MotorStageScenario>(),
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

// The carriage stands half the gap short of what the motor counts; half of what nobody
// knows is not taken off.
TEST(OfCarriage, TakesOffHalfOfTheGapThatIsKnown) {
  const std::vector<Contribution> readings = {{.input = "switch", .u = 0.003}};
  const Uncertain known =
      OfCarriage(2, {.value = 0.05, .sd = 0.008, .identifiable = true}, readings);
  const Uncertain unknown = OfCarriage(2, {}, readings);

  EXPECT_DOUBLE_EQ(known.value, 1.975);
  EXPECT_NEAR(known.sd, 0.005, 1e-12);  // 3, 4 and 5.
  EXPECT_EQ(unknown.value, 2);
  EXPECT_NEAR(unknown.sd, 0.003, 1e-12);
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

}  // namespace
}  // namespace caltwin

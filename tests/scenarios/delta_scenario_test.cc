#include "scenarios/kinds/delta_scenario.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenarios/machine_file.h"
#include "scenarios/runner.h"
#include "sim/effects/catalog.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;

const std::filesystem::path kName = CALTWIN_SOURCE_DIR "/scenarios/in_a_test.yaml";

Scenario ReadDeltaText(const std::string& keys) {
  return ReadScenarioText("machine: delta_printer\nfidelity: fast\n" + keys, kName);
}

std::string FaultOf(const std::string& keys) {
  try {
    ReadDeltaText(keys);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(DeltaScenario, EffectsMakeTheMachine) {
  const Scenario scenario = ReadDeltaText(
      "effects:\n"
      "  endstop.b: {error_mm: -0.2}\n"
      "  tower_angle.a: {angle_deg: 0.35}\n"
      "  rod_mismatch.c: {length_error_mm: 0.1}\n"
      "  rod_mismatch.a2: {length_error_mm: 0.3}\n"
      "  bed_cylinder.y: {height_um: 80}\n"
      "calibrate: [klipper_descent]\n");
  const BuiltDelta built =
      DrawDelta(*scenario.kind.As<DeltaScenario>(), scenario.machine.machine, 1, 0);

  EXPECT_DOUBLE_EQ(built.build.model.endstop_mm[1], 299.8);
  // The tower goes round with its carriage's joints, the effector's stay as drawn: 160
  // mm out to the carriage less 30 mm to the effector.
  const double turn_rad = 0.35 * M_PI / 180;
  const double out_mm = 160 * std::cos(turn_rad) - 30,
               round_mm = 160 * std::sin(turn_rad);
  EXPECT_NEAR(built.build.model.angle_rad[0],
              210 * M_PI / 180 + std::atan2(round_mm, out_mm),
              1e-14);
  EXPECT_NEAR(built.build.model.radius_mm[0], std::hypot(out_mm, round_mm), 1e-12);
  EXPECT_DOUBLE_EQ(built.build.twist_rad[0], turn_rad);
  EXPECT_DOUBLE_EQ(built.build.rod_error_mm[1], 0.3);
  EXPECT_DOUBLE_EQ(built.build.rod_error_mm[4], 0.1);
  EXPECT_DOUBLE_EQ(built.build.rod_error_mm[5], 0.1);
  EXPECT_DOUBLE_EQ(built.bed.cylinder_y_mm, 0.08);
}

TEST(DeltaScenario, WhatItTouchesWithIsSetToo) {
  const Scenario scenario = ReadDeltaText(
      "effects:\n"
      "  probe_offset: {dx_mm: 15, dz_mm: -2}\n"
      "  probe_pretravel.z: {pretravel_mm: 0.3}\n"
      "settings: {probe_offset_mm: [15, 0, -1.7]}\n"
      "calibrate:\n"
      "  - g33: {p: 6, c: 0.01, f: 2, o: true, t: false}\n");
  const BuiltDelta built =
      DrawDelta(*scenario.kind.As<DeltaScenario>(), scenario.machine.machine, 1, 0);

  EXPECT_EQ(built.tip.off_mm, Vec3<double>(15, 0, -2));
  EXPECT_EQ(built.tip.pretravel_mm, 0.3);
  EXPECT_EQ(scenario.kind.As<DeltaScenario>()->probe_offset_mm,
            Vec3<double>(15, 0, -1.7));
}

// What an extended machine file adds acts where the twin is built of parts; what it
// cannot build is a fault, never silence.
TEST(DeltaScenario, TheEffectsOfAMachineFileAct) {
  const std::filesystem::path machine =
      std::filesystem::path(::testing::TempDir()) / "extended_delta.yaml";
  const auto write = [&](const std::string& effects) {
    std::ofstream(machine) << "extends: " << CALTWIN_SOURCE_DIR
                           << "/models/delta_printer/machine.yaml\neffects:\n"
                           << effects;
  };
  const std::string text =
      "about: extended\nmachine: " + machine.string() + "\nseed: 1\ncalibrate: [g33]\n";
  write("  rod_mismatch.a1: {length_error_mm: 0.2}\n");
  const Scenario scenario = ReadScenarioText(text, "extended.yaml");
  const BuiltDelta built =
      DrawDelta(*scenario.kind.As<DeltaScenario>(), scenario.machine.machine, 1, 0);
  EXPECT_DOUBLE_EQ(built.build.rod_error_mm[0], 0.2);

  write("  carriage_backlash.c: {gap_mm: 0.06}\n");
  const Scenario loose = ReadScenarioText(text, "extended.yaml");
  EXPECT_EQ(
      DrawDelta(*loose.kind.As<DeltaScenario>(), loose.machine.machine, 1, 0).play_mm,
      (CarriageGaps_mm{0, 0, 0.06}));

  write("  trigger_latency: {latency_ms: 1}\n");
  try {
    ReadScenarioText(text, "extended.yaml");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("'trigger_latency' is no part of a delta"));
  }
}

TEST(DeltaScenario, EveryEffectIsExplained) {
  std::vector<std::string> unexplained;
  for (const std::string& name : DeltaEffectNames()) {
    const bool is_delta =
        std::ranges::any_of(DeltaScenario().OwnEffects(),
                            [&](const Word& word) { return word.name == name; });
    const bool is_any = std::ranges::any_of(
        AllEffects(), [&](const Effect* effect) { return effect->name == name; });
    if (!is_delta && !is_any) unexplained.push_back(name);
  }
  EXPECT_THAT(unexplained, ::testing::IsEmpty());
}

TEST(DeltaScenario, TellsWhatItDoesNotKnow) {
  const std::string calibrate = "calibrate: [g33]\n";
  EXPECT_THAT(FaultOf("effects: {tower_lena.a: {radial_mrad: 1}}\n" + calibrate),
              HasSubstr("did you mean 'tower_lean'?"));
  EXPECT_THAT(FaultOf("effects: {endstop: {error_mm: 1}}\n" + calibrate),
              HasSubstr("'endstop' stands with .a .b .c"));
  EXPECT_THAT(FaultOf("effects: {endstop.a: {error_mm: 100}}\n" + calibrate),
              HasSubstr("is outside -20 .. 20"));
  EXPECT_THAT(FaultOf("effects: {probe_pretravel.x: {pretravel_mm: 1}}\n" + calibrate),
              HasSubstr("'probe_pretravel' stands with .z"));
  EXPECT_THAT(FaultOf("settings: {probe_offset_mm: [1, 2]}\n" + calibrate),
              HasSubstr("is not three numbers"));
  EXPECT_THAT(FaultOf("calibrate: [{g33: {f: 31}}]\n"),
              HasSubstr("is outside 0 .. 30"));
  EXPECT_THAT(FaultOf("calibrate: [next_all]\n"),
              HasSubstr("is a procedure of a gantry, not of a delta"));
  EXPECT_THAT(FaultOf(calibrate + "expect: {flatness: {below: 1}}\n"),
              HasSubstr("expect.flatness is no parameter that this version knows\n"
                        "  it knows endstop.a, "));
}

// By G-code alone, through whole motor steps: what G33 cannot know, the estimate says.
TEST(DeltaScenario, EveryProcedureFlattensAWrongRadius) {
  for (const char* procedure :
       {"g33", "rrf_least_squares", "klipper_descent", "delta_joint"}) {
    const RunResult result = RunScenario(
        ReadDeltaText(std::string("effects: {delta_radius: {error_mm: 0.8}}\n"
                                  "calibrate: [") +
                      procedure + "]\nexpect: {delta_radius: {truth_within: 0.1}}\n"));
    EXPECT_EQ(result.outcome, "recovers") << procedure;
    EXPECT_TRUE(result.passed) << procedure;
    EXPECT_GT(result.touches, 0) << procedure;
  }
}

// What no touch tells a calliper does: rods 0.4 mm longer than believed.
TEST(DeltaScenario, RodsAndPrintsAreReadByCalliper) {
  const std::string rods = "effects: {arm_length: {error_mm: 0.4}}\ncalibrate:\n";
  const std::string all =
      "fit: [endstop.a, endstop.b, endstop.c, delta_radius, tower_angle.a, "
      "tower_angle.b, arm_length]";
  const std::string found =
      "expect:\n  arm_length: {truth_within: 0.05}\n"
      "  xy_scale_um_per_mm: {above: -0.3, below: 0.3}\n";
  for (const std::string& step :
       {"delta_joint: {" + all + ", rods: true}",
        "delta_joint: {" + all + ", print: true}",
        "delta_joint: {" + all + ", priors: {arm_length: {value: 250.4, sd: 0.01}}}",
        std::string("klipper_descent: {print: true}")}) {
    const RunResult result =
        RunScenario(ReadDeltaText(rods + "  - " + step + "\n" + found));
    const double scale = 1e3 * *result.parameters[6].error / 250;
    EXPECT_LT(std::abs(scale), 0.3) << step;
    for (const CheckResult& check : result.checks) {
      if (check.name == "outcome") continue;
      EXPECT_TRUE(check.passed) << step << check.name << check.found;
    }
  }
}

TEST(DeltaScenario, AnySubsetOfUnknownsIsFitted) {
  const RunResult result = RunScenario(
      ReadDeltaText("effects: {delta_radius: {error_mm: 0.8}}\n"
                    "calibrate: [{delta_joint: {fit: [delta_radius, endstop.a, "
                    "bed_tilt.slope_x_mrad]}}]\n"));

  EXPECT_EQ(result.outcome, "recovers");
  EXPECT_EQ(result.parameters.size(), 8U);  // Seven settings, and the slope.
  EXPECT_THAT(result.messages[0],
              HasSubstr("joint estimate of 3 unknowns from 37 touches: 0.0"));
  EXPECT_THAT(result.messages[0], HasSubstr("mm of points left out"));
  EXPECT_THAT(result.messages[1], HasSubstr("one touch more would tell most at X"));
}

TEST(DeltaScenario, TellsWhatAStepDoesNotKnow) {
  const auto fault = [](const std::string& step) {
    return FaultOf("calibrate: [{" + step + "}]\n");
  };
  EXPECT_THAT(fault("delta_joint: {fit: [delta_radus]}"),
              HasSubstr("did you mean 'delta_radius'?"));
  EXPECT_THAT(fault("delta_joint: {fit: [delta_radius, delta_radius]}"),
              HasSubstr("stands twice"));
  EXPECT_THAT(fault("delta_joint: {fit: []}"), HasSubstr("is empty"));
  EXPECT_THAT(fault("delta_joint: {fit: [delta_radius], unknowns: machine}"),
              HasSubstr("stands beside 'unknowns'"));
  EXPECT_THAT(fault("delta_joint: {priors: {arm_length: {value: 250, sd: 0.1}}}"),
              HasSubstr("'arm_length' is not among the unknowns of this step"));
  EXPECT_THAT(fault("delta_joint: {priors: {delta_radius: {value: 130}}}"),
              HasSubstr("priors.delta_radius lacks the key 'sd'"));
  EXPECT_THAT(fault("klipper_descent: {points: 7}"), HasSubstr("It knows: print"));
  EXPECT_THAT(fault("g33: {p: 4, r: 200}"), HasSubstr("no disc is left to touch"));
}

// Whole motor steps of 12.5 um: each calibration reads a little else, and none after
// the first finds anything worth setting.
TEST(DeltaScenario, ASecondCalibrationLeavesTheMachineAlone) {
  const RunResult result = RunScenario(
      ReadDeltaText("effects: {delta_radius: {error_mm: 0.8}, endstop.a: {error_mm: "
                    "0.3}}\ncalibrate: [delta_joint, delta_joint]\n"
                    "expect: {height_drift_mm: {below: 1.0e-9}}\n"));

  EXPECT_TRUE(result.passed);
  EXPECT_THAT(result.messages,
              ::testing::Contains(HasSubstr("the settings are kept: others would")));
}

// Unlike rods, which settings cannot hold, in a mesh that the touches foretell.
TEST(DeltaScenario, AMeshHoldsWhatSettingsCannot) {
  const auto left_mm = [](const std::string& mesh) {
    const RunResult result = RunScenario(ReadDeltaText(
        "effects: {rod_mismatch.a1: {length_error_mm: 0.3}, rod_mismatch.b2: "
        "{length_error_mm: -0.2}}\ncalibrate: [{delta_joint: {unknowns: machine" +
        mesh + "}}]\nexpect: {height_error_mm.rms: {below: 1}}\n"));
    return std::stod(result.checks[1].found);
  };

  EXPECT_LT(left_mm(", mesh: true"), 0.5 * left_mm(""));
}

// Touches of a run are rows like any others: by the settings in force, of whole steps.
TEST(DeltaScenario, ARunIsRecordedAsRows) {
  const RunResult result =
      RunScenario(ReadDeltaText("effects: {delta_radius: {error_mm: 0.8}}\n"
                                "calibrate: [delta_joint, {g33: {p: 4}}]\n"));

  ASSERT_EQ(static_cast<int>(result.rows.rows.size()), result.touches);
  const Row& first = result.rows.rows.front();
  EXPECT_EQ(first.campaign, "delta_joint");
  EXPECT_EQ(first.settings, "s1");
  EXPECT_EQ(first.feature, "bed.top");
  EXPECT_NEAR(first.value_mm, 0, 0.02);  // The middle, which a radius does not move.
  const Vec3<double> nominal = DeltaMotors_mm<double>(
      SymmetricDelta(300, 130, 250), {first.cmd_mm[0], first.cmd_mm[1], 0});
  EXPECT_NEAR(first.motor_mm[1], nominal[1], 1e-9);
  EXPECT_EQ(result.rows.rows[37].campaign, "g33");
  EXPECT_EQ(result.rows.rows[37].settings, "s2");
  EXPECT_EQ(result.header.settings.at("s2").steps_per_mm.at("a"), 80);
}

TEST(DeltaScenario, SameSeedGivesTheSameRun) {
  const Scenario scenario = ReadDeltaText(
      "effects: {delta_radius: {error_mm: {normal: {mean: 0, sd: 0.5}}}}\n"
      "instruments: {probe: {sigma_um: 5}}\n"
      "calibrate: [delta_joint]\n");
  const RunResult one = RunScenario(scenario, {.seed = 3});
  const RunResult again = RunScenario(scenario, {.seed = 3});
  const RunResult other = RunScenario(scenario, {.seed = 4});

  EXPECT_EQ(*one.parameters[3].recovered, *again.parameters[3].recovered);
  EXPECT_NE(*one.parameters[3].recovered, *other.parameters[3].recovered);
}

TEST(DeltaScenario, OtherCommandsSayThatTheyDoNotKnowDeltas) {
  try {
    ReadMachineFile(CALTWIN_SOURCE_DIR "/models/delta_printer/machine.yaml");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("a delta, which this command does not know"));
  }
}

}  // namespace
}  // namespace caltwin

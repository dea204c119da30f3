#include "scenarios/delta_scenario.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenarios/delta_words.h"
#include "scenarios/machine_file.h"
#include "scenarios/runner.h"
#include "sim/effects/catalog.h"

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
  const BuiltDelta built = DrawDelta(*scenario.delta, scenario.machine.machine, 1, 0);

  EXPECT_DOUBLE_EQ(built.build.model.endstop_mm[1], 299.8);
  EXPECT_NEAR(built.build.model.angle_rad[0] * 180 / M_PI, 210.35, 1e-12);
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
  const BuiltDelta built = DrawDelta(*scenario.delta, scenario.machine.machine, 1, 0);

  EXPECT_EQ(built.tip.off_mm, Vec3<double>(15, 0, -2));
  EXPECT_EQ(built.tip.pretravel_mm, 0.3);
  EXPECT_EQ(scenario.delta->probe_offset_mm, Vec3<double>(15, 0, -1.7));
  EXPECT_EQ(scenario.delta->calibrate[0].words, " C0.01 F2 O");
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
  const BuiltDelta built = DrawDelta(*scenario.delta, scenario.machine.machine, 1, 0);
  EXPECT_DOUBLE_EQ(built.build.rod_error_mm[0], 0.2);

  write("  carriage_backlash.c: {gap_mm: 0.06}\n");
  try {
    ReadScenarioText(text, "extended.yaml");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("'carriage_backlash' is no part of a delta"));
  }
}

TEST(DeltaScenario, EveryEffectIsExplained) {
  std::vector<std::string> unexplained;
  for (const std::string& name : DeltaEffectNames()) {
    const bool is_delta = std::ranges::any_of(
        DeltaEffectWords(), [&](const Word& word) { return word.name == name; });
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
              HasSubstr("'next_all' is no procedure of a delta"));
  EXPECT_THAT(FaultOf(calibrate + "expect: {flatness: {below: 1}}\n"),
              HasSubstr("has no key 'flatness'"));
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
    EXPECT_THAT(error.what(),
                HasSubstr("a delta, which serve, calibrate and closed loops"));
  }
}

}  // namespace
}  // namespace caltwin

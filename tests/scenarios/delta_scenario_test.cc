#include "scenarios/delta_scenario.h"

#include <algorithm>

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

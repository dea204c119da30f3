#include "scenarios/runner.h"

#include <cmath>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "scenarios/result_text.h"
#include "sim/base/text_file.h"

namespace caltwin {
namespace {

using ::testing::Contains;
using ::testing::DoubleEq;
using ::testing::DoubleNear;
using ::testing::Eq;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::Optional;
using ::testing::SizeIs;
using ::testing::StrEq;

// A fast gantry: x built with a gap of 0.05 mm, its firmware 1 % wrong; `steps` is what
// stands behind `calibrate:`.
Scenario WornGantry(const std::string& steps, const std::string& more = "") {
  return ReadScenarioText(
      "machine: gantry_router\n"
      "fidelity: fast\n"
      "effects: {backlash.x: {gap_mm: 0.05}}\n"
      "settings: {steps_per_mm: {x: 808}}\n"
      "calibrate: " +
          steps + "\n" + more,
      "worn.yaml");
}

const ParameterResult& RowOf(const RunResult& result, const std::string& name) {
  return *std::ranges::find(result.parameters, name, &ParameterResult::name);
}

TEST(Runner, SettingsSentAsGcodeAreWhatIsRecovered) {
  const RunResult result = RunScenario(WornGantry(
      "[gcode: {lines: [M92 X800, M425 X0.05]}]",
      "expect: {steps_per_mm.x: {truth_within: 0.001}, backlash.x: {truth_within: "
      "0.0001}}\n"));

  EXPECT_TRUE(result.passed);
  EXPECT_THAT(result.outcome, StrEq("recovers"));
  EXPECT_THAT(RowOf(result, "steps_per_mm.x").recovered, Optional(DoubleEq(800)));
  EXPECT_THAT(RowOf(result, "backlash.x").injected, DoubleEq(0.05));
  EXPECT_THAT(RowOf(result, "backlash.x").error, Optional(DoubleNear(0, 1e-9)));
  EXPECT_THAT(result.position_error_after_p95_mm, DoubleNear(0, 1e-9));
}

TEST(Runner, AFailedExpectationFailsTheRun) {
  const RunResult result =
      RunScenario(WornGantry("[gcode: {lines: [M92 X801]}]",
                             "expect: {steps_per_mm.x: {truth_within: 0.5}}\n"));

  EXPECT_FALSE(result.passed);
  EXPECT_THAT(RowOf(result, "steps_per_mm.x").passed, Optional(false));
  EXPECT_THAT(result.outcome, StrEq("misses"));
}

TEST(Runner, AMissedTruthFailsEvenWhereMissingIsTheExpectedOutcome) {
  const RunResult result = RunScenario(
      WornGantry("[gcode: {lines: [M92 X801]}]",
                 "expect: {outcome: misses, steps_per_mm.x: {truth_within: 0.5}}\n"));

  EXPECT_THAT(result.outcome, StrEq("misses"));
  EXPECT_FALSE(result.passed);
}

// Both settings right but for x's scale: its error is s (q - home), uniform over the
// travel; p95 of its distance from the mean is 0.95 * s * travel / 2.
TEST(Runner, PositionErrorOfAScaleIsItsSlopeOverTheTravel) {
  const RunResult result = RunScenario(ReadScenarioText(
      "machine: gantry_router\nfidelity: fast\nsettings: {steps_per_mm: {x: 808}}\n"
      "calibrate: [gcode: {lines: [M114]}]\n",
      "scale.yaml"));

  const double expected_mm = 0.95 * (808.0 / 800 - 1) * 300 / 2;
  const double sampling_mm = 4 * expected_mm * std::sqrt(0.95 * 0.05 / 1000) / 0.95;
  EXPECT_THAT(result.position_error_before_p95_mm,
              DoubleNear(expected_mm, sampling_mm));
}

// A gap alone: every pose is off by b/2, one way or the other, and the mean is zero.
TEST(Runner, PositionErrorOfAGapIsHalfOfIt) {
  const RunResult result = RunScenario(ReadScenarioText(
      "machine: gantry_router\nfidelity: fast\neffects: {backlash.x: {gap_mm: 0.05}}\n"
      "calibrate: [gcode: {lines: [M114]}]\n",
      "gap.yaml"));

  EXPECT_THAT(result.position_error_before_p95_mm, DoubleNear(0.025, 1e-9));
}

TEST(Runner, ARefusedLineIsAnOutcome) {
  const RunResult result =
      RunScenario(WornGantry("[gcode: {lines: [G1 X10 F600]}]",
                             "expect: {outcome: refused}\n"));  // Not homed.

  EXPECT_TRUE(result.passed);
  EXPECT_THAT(result.messages, Contains(HasSubstr("G1 X10 F600")));
}

TEST(Runner, TheSameSeedGivesTheSameResult) {
  const Scenario scenario = ReadScenarioText(
      "machine: gantry_router\nfidelity: fast\n"
      "effects: {backlash.x: {gap_mm: {uniform: {min: 0, max: 0.1}}}}\n"
      "calibrate: [gcode: {lines: [M114]}]\n",
      "drawn.yaml");

  const auto gap_mm = [&](std::uint64_t seed) {
    return RowOf(RunScenario(scenario, {.seed = seed}), "backlash.x").injected;
  };
  EXPECT_THAT(gap_mm(3), DoubleEq(gap_mm(3)));
  EXPECT_NE(gap_mm(3), gap_mm(4));
}

TEST(Runner, AnExternalProgramTalksToTheMachine) {
  const RunResult result = RunScenario(WornGantry(
      R"([external: {command: [sh, -c, "echo M92 X800; echo 'M118 ESTIMATE backlash.x 0.049 0.002'"]}])",
      "expect: {steps_per_mm.x: {truth_within: 0.001}}\n"));

  EXPECT_TRUE(result.passed);
  EXPECT_THAT(result.checks.back().found, StrEq("exited with 0"));
  ASSERT_THAT(result.steps, SizeIs(1));
  EXPECT_THAT(result.steps[0].name, StrEq("steps_per_mm.x"));
  EXPECT_THAT(RowOf(result, "backlash.x").sd, Optional(DoubleEq(0.002)));
}

TEST(Runner, AnExternalProgramThatFailsIsAFailedStep) {
  const RunResult result =
      RunScenario(WornGantry("[external: {command: [sh, -c, 'exit 4']}]"));

  EXPECT_FALSE(result.passed);
  EXPECT_FALSE(result.lost);
  EXPECT_THAT(result.checks.back().found, StrEq("exited with 4"));
}

TEST(Runner, AnExternalProgramThatDiesIsLost) {
  const RunResult result =
      RunScenario(WornGantry("[external: {command: [sh, -c, 'kill -9 $$']}]"));

  EXPECT_TRUE(result.lost);
  EXPECT_FALSE(result.passed);
}

TEST(Runner, KeepsATranscriptOfEveryLine) {
  const auto file = std::filesystem::path(::testing::TempDir()) / "run.transcript";

  RunScenario(WornGantry("[gcode: {lines: [M92 X800]}]"), {.transcript = file});

  EXPECT_THAT(ReadTextFile(file, 10'000), HasSubstr("> M92 X800\n"));
}

TEST(Runner, HoldsTheTranscriptWhereAskedAndNeverAsJson) {
  const Scenario scenario = WornGantry("[gcode: {lines: [M92 X800]}]");

  const RunResult held = RunScenario(scenario, {.holds_transcript = true});

  EXPECT_THAT(held.transcript, HasSubstr("> M92 X800\n"));
  EXPECT_THAT(ToJson(held).dump(), Not(HasSubstr("> M92 X800")));
  EXPECT_EQ(RunScenario(scenario).transcript, "");
}

TEST(ResultText, ShowsAsManyDigitsAsTheUncertaintyWarrants) {
  EXPECT_THAT(Sensible(800.012345, 0.023), StrEq("800.012"));
  EXPECT_THAT(Sensible(800.012345, 0.5), StrEq("800.01"));
  EXPECT_THAT(Sensible(800.012345, 25), StrEq("800"));
  EXPECT_THAT(Sensible(0.0000001, 1e-9), StrEq("0.000000"));
  EXPECT_THAT(Sensible(-0.0001, 0.1), StrEq("0.00"));
  EXPECT_THAT(Sensible(800.012345, std::nullopt), StrEq("800.012"));
}

// The verdict stands first; of checks what failed; of messages how many.
TEST(ResultText, TheBriefOneSaysTheVerdictFirst) {
  RunResult result{.scenario = "x.yaml",
                   .about = "A worn axis.",
                   .passed = false,
                   .outcome = "misses"};
  result.messages = {"a message"};
  result.checks = {{.name = "outcome", .expected = "recovers", .found = "misses"},
                   {.name = "alarm", .found = "none", .passed = true}};

  const std::string text = ResultBrief(result);

  EXPECT_TRUE(text.starts_with(
      "FAILED: The calibration ended off the truth, which was not expected: 1 of 2 "
      "expectations met.\noutcome: expected recovers, found misses.\n"))
      << text;
  EXPECT_THAT(text, HasSubstr("A worn axis."));
  EXPECT_THAT(text, HasSubstr("outcome: misses, expected recovers"));
  EXPECT_THAT(text, testing::Not(HasSubstr("alarm")));
  EXPECT_THAT(text, testing::Not(HasSubstr("a message")));
  EXPECT_THAT(
      text,
      HasSubstr("--verbose shows how sure each is and why, 0 steps and 1 messages"));
}

TEST(Coverage, CountsIntervalsThatHoldTheTruth) {
  RunResult result;
  const auto add = [&](double error, std::optional<double> sd) {
    result.parameters.push_back({.sd = sd, .error = error, .identifiable = true});
  };
  add(0.1, 0.1);           // Held: 1 sd.
  add(-0.19, 0.1);         // Held: 1.9 sd.
  add(0.2, 0.1);           // Missed: 2 sd.
  add(5.0, std::nullopt);  // Stated nothing.

  EXPECT_THAT(Coverage95(std::span(&result, 1)), Optional(DoubleNear(2.0 / 3, 1e-12)));
  EXPECT_THAT(Coverage95({}), Eq(std::nullopt));
}

}  // namespace
}  // namespace caltwin

#include <algorithm>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "scenarios/runner.h"
#include "sim/base/input_error.h"

namespace caltwin {
namespace {

using ::testing::Eq;
using ::testing::HasSubstr;
using ::testing::StrEq;

/// A kind of machine, by a scenario that passes.
struct Kind {
  std::string name{};
  std::string scenario{};
  std::string parameter{}, figure{};  ///< That a scenario of it may expect.
  std::string line{};                 ///< Of G-code, which its controller obeys.
  std::string spoils{};  ///< Lines that leave it worse than it was; empty: none do.
};

std::string TextOf(const Kind& kind) {
  std::ifstream file(CALTWIN_SOURCE_DIR "/scenarios/" + kind.scenario + ".yaml");
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// With those steps before its own, or behind them.
std::string With(const std::string& first, const std::string& last, std::string text) {
  const std::string calibrate = "calibrate:\n";
  text.insert(text.find(calibrate) + calibrate.size(), first);
  text.insert(text.find("expect:"), last);
  return text;
}

Scenario Read(const std::string& text) {
  Scenario scenario =
      ReadScenarioText(text, CALTWIN_SOURCE_DIR "/scenarios/made_up.yaml");
  scenario.fidelity = Fidelity::kFast;
  return scenario;
}

const std::vector<Kind>& Kinds() {
  static const std::vector<Kind> kAll = {
      Kind{"gantry",
           "next_dual_dimension_corrected",
           "backlash.x",
           "position_error_mm.p95",
           "G28",
           "M92 X400"},
      Kind{"delta",
           "delta_g33_p4_recovers",
           "delta_radius",
           "height_error_mm.rms",
           "G28",
           "M665 R190"},
      Kind{"triple_z",
           "tz_levels_in_one_round",
           "bed_tilt.slope_x_mrad",
           "level_error_mm.mean",
           "G28",
           ""},
      Kind{"z_station",
           "z_offset_wrong_switch_offset_found",
           "switch_offset",
           "z_offset_error_mm",
           "G28",
           "SET_GCODE_OFFSET Z=5"},
      Kind{"motor_stage", "motor_servo_home", "home_offset.x", "alerts", "M504", ""}};
  return kAll;
}

std::vector<Kind> ThoseThatALineSpoils() {
  std::vector<Kind> kinds = Kinds();
  std::erase_if(kinds, [](const Kind& kind) { return kind.spoils.empty(); });
  return kinds;
}

std::string NameOf(const ::testing::TestParamInfo<Kind>& test) {
  return test.param.name;
}

class EveryKind : public ::testing::TestWithParam<Kind> {};
INSTANTIATE_TEST_SUITE_P(AsListed, EveryKind, ::testing::ValuesIn(Kinds()), NameOf);

class SpoiltKind : public ::testing::TestWithParam<Kind> {};
INSTANTIATE_TEST_SUITE_P(AsListed,
                         SpoiltKind,
                         ::testing::ValuesIn(ThoseThatALineSpoils()),
                         NameOf);

TEST_P(EveryKind, AnyOtherOutcomeWordFails) {
  Scenario scenario = Read(TextOf(GetParam()));
  const RunResult right = RunScenario(scenario);
  ASSERT_TRUE(right.passed) << right.outcome;

  for (const std::string word : kOutcomes) {
    if (word == right.outcome) continue;
    scenario.expect.outcome = word;
    EXPECT_FALSE(RunScenario(scenario).passed) << word;
  }
}

TEST_P(EveryKind, AnExpectationOfNothingIsRefused) {
  for (const std::string& name :
       {GetParam().parameter, GetParam().figure, std::string("machine_time_s")}) {
    std::string text = TextOf(GetParam());
    text = text.substr(0, text.find("expect:")) + "expect: {" + name + ": {}}\n";
    try {
      Read(text);
      FAIL() << name;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("expect." + name + " expects nothing"));
    }
  }
}

TEST_P(EveryKind, EveryOutcomeWordCanBeExpected) {
  for (const std::string word : kOutcomes) {
    std::string text = TextOf(GetParam());
    text = text.substr(0, text.find("expect:")) + "expect: {outcome: " + word + "}\n";
    EXPECT_THAT(Read(text).expect.outcome, StrEq(word));
  }
}

TEST_P(EveryKind, TakesLinesAndProgramsAsSteps) {
  const Scenario scenario =
      Read(With("  - gcode: {lines: [" + GetParam().line +
                    "]}\n  - external: {command: [sh, -c, exit 0]}\n",
                "",
                TextOf(GetParam())));

  const RunResult result = RunScenario(scenario);

  const auto check = std::ranges::find(result.checks, "external", &CheckResult::name);
  ASSERT_NE(check, result.checks.end());
  EXPECT_TRUE(check->passed);
  EXPECT_FALSE(result.lost);
}

TEST_P(EveryKind, AProgramThatIsKilledLosesTheRun) {
  const Scenario scenario = Read(
      With("  - external: {command: [sh, -c, kill -9 $$]}\n", "", TextOf(GetParam())));

  const RunResult result = RunScenario(scenario);

  EXPECT_TRUE(result.lost);
  EXPECT_FALSE(result.passed);
}

// What nobody calibrated is not recovered because nobody looked at it.
TEST_P(SpoiltKind, LeftWorseThanItWasItDiverges) {
  Scenario scenario = Read(With(
      "", "  - gcode: {lines: [" + GetParam().spoils + "]}\n", TextOf(GetParam())));
  scenario.expect = {};

  const RunResult result = RunScenario(scenario);

  EXPECT_THAT(result.outcome, StrEq("diverges"));
  EXPECT_FALSE(result.passed);
}

TEST(SpoiltBed, LevellingWithTheScrewsEnteredWronglyDiverges) {
  const Scenario scenario = Read(
      "machine: triple_z_printer\n"
      "effects: {bed_tilt: {slope_x_mrad: 4, slope_y_mrad: 1}}\n"
      "settings: {screws_at_mm: {z1: [215, 20], z2: [20, 20]}}\n"
      "calibrate:\n"
      "  - gcode: {lines: [G28, G30 P0 X30 Y30 Z-99999, G30 P1 X200 Y30 Z-99999, "
      "G30 P2 X30 Y200 Z-99999 S3]}\n");

  const RunResult result = RunScenario(scenario);

  EXPECT_THAT(result.outcome, StrEq("diverges"));
  EXPECT_FALSE(result.passed);
}

TEST_P(EveryKind, AnswersInPrintableText) {
  const Scenario scenario = Read(TextOf(GetParam()));
  const auto trial = scenario.kind->Begin(scenario, {.fidelity = Fidelity::kFast});

  for (const std::string line : {"foo",
                                 "F",
                                 "x1y2",
                                 "G",
                                 "M",
                                 "G999",
                                 "M9999 P\"a\"",
                                 "N1 foo*2",
                                 "T",
                                 "?",
                                 "$$",
                                 "{",
                                 "if",
                                 "M117 \x01\x7f",
                                 "G1 X\t1",
                                 "\xc3\xa4"}) {
    const auto reply = trial->wire()->Send(line, std::chrono::milliseconds(1000));
    std::string said = reply ? "" : reply.error().reply;
    if (reply) {
      for (const std::string& each : *reply) said += each + "\n";
    }
    const auto unprintable = std::ranges::count_if(said, [](unsigned char c) {
      return (c < 0x20 && c != '\n' && c != '\t') || c == 0x7f;
    });
    EXPECT_THAT(unprintable, Eq(0)) << "answer to " << line << ": " << said;
  }
}

}  // namespace
}  // namespace caltwin

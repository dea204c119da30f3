#include "scenarios/scenario.h"

#include <algorithm>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/text_file.h"
#include "sim/effects/catalog.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;

using ::testing::DoubleEq;
using ::testing::ElementsAre;
using ::testing::Eq;
using ::testing::IsEmpty;
using ::testing::Optional;
using ::testing::SizeIs;
using ::testing::StrEq;

constexpr const char* kEverything = R"(
about: All keys at once.
machine: gantry_router
seed: 7
fidelity: fast
effects:
  backlash.x: {gap_mm: {uniform: {min: 0.01, max: 0.02}}}
settings:
  steps_per_mm: {x: 808}
instruments: {probe: {sigma_um: 1}}
artefacts: {block: {type: block123, at_mm: [150, 150, 0], side: x}}
firmware: {m400_ignores_backlash: true, files: {sys/nxt-user-vars.g: "M92 X801"}}
calibrate:
  - gcode: {lines: [M114, M92]}
  - external: {command: [prog, arg], timeout_s: 1.5}
expect:
  outcome: diverges
  steps_per_mm.x: {truth_within: 0.08, identifiable: true, steps: {after: [816, 832], within: 1}}
  backlash.x: {reads: {value: 0, within: 0.001}, sd_below: 0.1, truth_within_sd: 4}
  position_error_mm.p95: {below: 0.02}
  messages: [check the stylus]
)";

TEST(Scenario, EveryKeyIsRead) {
  const Scenario scenario = ReadScenarioText(kEverything, "somewhere/all.yaml");

  EXPECT_THAT(scenario.about, StrEq("All keys at once."));
  EXPECT_THAT(scenario.machine.machine.name, StrEq("gantry_router"));
  EXPECT_THAT(scenario.seed, Eq(7u));
  EXPECT_THAT(scenario.fidelity, Eq(Fidelity::kFast));
  ASSERT_THAT(scenario.effects, SizeIs(1));
  EXPECT_THAT(scenario.effects[0].effect, Eq(EffectIndex<Backlash>()));
  ASSERT_THAT(scenario.settings, SizeIs(1));
  EXPECT_THAT(scenario.settings[0].key, StrEq("steps_per_mm"));
  EXPECT_THAT(scenario.artefacts, SizeIs(1));
  EXPECT_THAT(scenario.instruments.at("probe").sigma_um, DoubleEq(1));
  EXPECT_TRUE(scenario.firmware.m400_ignores_backlash);
  EXPECT_THAT(scenario.firmware.files.at("sys/nxt-user-vars.g"), StrEq("M92 X801"));
  ASSERT_THAT(scenario.calibrate, SizeIs(2));
  ASSERT_TRUE(scenario.calibrate[1].external.has_value());
  const ChildCommand& child = scenario.calibrate[1].external->child;
  EXPECT_THAT(child.words, ElementsAre("prog", "arg"));
  EXPECT_THAT(child.patience, Eq(std::chrono::milliseconds(1500)));
  EXPECT_THAT(child.folder, Eq(fs::path("somewhere")));
}

TEST(Scenario, EveryExpectationIsRead) {
  const Expectation expect = ReadScenarioText(kEverything, "all.yaml").expect;

  EXPECT_THAT(expect.outcome, StrEq("diverges"));
  ASSERT_THAT(expect.parameters, SizeIs(2));
  const ParameterExpectation& steps = expect.parameters[0];
  EXPECT_THAT(steps.truth_within, Optional(0.08));
  EXPECT_THAT(steps.identifiable, Optional(true));
  EXPECT_THAT(steps.steps, ElementsAre(816, 832));
  EXPECT_THAT(steps.steps_within, DoubleEq(1));
  const ParameterExpectation& backlash = expect.parameters[1];
  EXPECT_THAT(backlash.reads->within, DoubleEq(0.001));
  EXPECT_THAT(backlash.sd_below, Optional(0.1));
  EXPECT_THAT(backlash.truth_within_sd, Optional(4.0));
  ASSERT_THAT(expect.figures, SizeIs(1));
  EXPECT_THAT(expect.figures[0].name, StrEq("position_error_mm.p95"));
  EXPECT_THAT(expect.figures[0].within.below, Optional(0.02));
  EXPECT_THAT(expect.messages, ElementsAre("check the stylus"));
}

TEST(Scenario, WithoutExpectMustRecover) {
  const Scenario scenario = ReadScenarioText(
      "machine: gantry_router\ncalibrate: [gcode: {lines: [M114]}]\n", "a.yaml");

  EXPECT_THAT(scenario.expect.outcome, StrEq("recovers"));
  EXPECT_THAT(scenario.fidelity, Eq(Fidelity::kPhysics));
  EXPECT_THAT(scenario.expect.parameters, IsEmpty());
}

// The text with every `from` replaced.
std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos;
       at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
  return text;
}

std::vector<std::string> BadFiles() {
  std::vector<std::string> names;
  const fs::path folder = fs::path(CALTWIN_SOURCE_DIR) / "tests/data/scenarios_bad";
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem());
  }
  std::ranges::sort(names);
  return names;
}

class BadScenario : public ::testing::TestWithParam<std::string> {};

// Each file's .expected holds the messages whole, paths shortened.
TEST_P(BadScenario, SaysWhatIsWrongAndWhatIsAllowed) {
  const std::string folder = "tests/data/scenarios_bad/";
  const std::string expected = ReadTextFile(folder + GetParam() + ".expected", 100'000);

  try {
    ReadScenario(folder + GetParam() + ".yaml");
    FAIL() << "it was read as if nothing were wrong";
  } catch (const InputError& error) {
    const std::string text = Replaced(
        Replaced(FaultsText(error), folder, ""), CALTWIN_SOURCE_DIR, "@SOURCE@");
    EXPECT_THAT(text, StrEq(expected));
  }
}

INSTANTIATE_TEST_SUITE_P(,
                         BadScenario,
                         ::testing::ValuesIn(BadFiles()),
                         [](const auto& test) { return test.param; });

}  // namespace
}  // namespace caltwin

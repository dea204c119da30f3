#include <algorithm>
#include <filesystem>
#include <map>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenarios/runner.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;

/// A scenario of one of the published troubles, and all that its run said.
struct TroubleRun {
  std::vector<std::string> expected{};
  std::vector<std::string> said{};
  std::vector<std::string> causes{};
  bool passed = false;

  bool LeadsWith(const std::string& text) const {
    return std::ranges::any_of(causes, [&](const std::string& cause) {
      return cause.find(text) != std::string::npos;
    });
  }

  bool Says(const std::string& text) const {
    return std::ranges::any_of(said, [&](const std::string& message) {
      return message.find(text) != std::string::npos;
    });
  }
};

std::map<std::string, TroubleRun> RunTroubles() {
  std::map<std::string, TroubleRun> runs;
  for (const auto& entry : fs::directory_iterator(CALTWIN_SOURCE_DIR "/scenarios")) {
    const std::string name = entry.path().stem();
    const bool is_one =
        name.starts_with("trouble_") && entry.path().extension() == ".yaml";
    if (!is_one) continue;
    Scenario scenario = ReadScenario(entry.path());
    scenario.fidelity = Fidelity::kFast;
    const RunResult result = RunScenario(scenario);
    TroubleRun& run = runs[name];
    run.expected = scenario.expect.messages;
    run.passed = result.passed;
    run.causes = result.Causes();
    for (const Message& message : result.messages) run.said.push_back(message.text);
  }
  return runs;
}

// The published lists have eight troubles of a bed and four of a mill.
TEST(Troubles, EachIsNamedByItsCauseAndByNoOther) {
  const auto runs = RunTroubles();

  EXPECT_GE(runs.size(), 8u + 4u);
  for (const auto& [name, run] : runs) {
    EXPECT_TRUE(run.passed) << name;
    EXPECT_TRUE(std::ranges::any_of(run.expected, [&](const std::string& text) {
      return run.LeadsWith(text);
    })) << name;
    for (const auto& [other, its] : runs) {
      const bool is_named = std::ranges::all_of(
          run.expected, [&](const std::string& text) { return its.Says(text); });
      EXPECT_EQ(is_named, name == other) << name << " expected of " << other;
    }
  }
}

}  // namespace
}  // namespace caltwin

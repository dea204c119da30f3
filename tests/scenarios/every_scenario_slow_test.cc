#include <algorithm>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenarios/result_text.h"
#include "scenarios/runner.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> ScenarioNames() {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(CALTWIN_SOURCE_DIR "/scenarios")) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem());
  }
  std::ranges::sort(names);
  return names;
}

class EveryScenario : public ::testing::TestWithParam<std::string> {};

// In the fidelity, with the seed and to the expectations that the file itself states.
TEST_P(EveryScenario, MeetsItsOwnExpectations) {
  const RunResult result =
      RunScenario(ReadScenario("scenarios/" + GetParam() + ".yaml"));

  EXPECT_TRUE(result.passed) << ResultText(result);
}

INSTANTIATE_TEST_SUITE_P(,
                         EveryScenario,
                         ::testing::ValuesIn(ScenarioNames()),
                         [](const auto& test) { return test.param; });

TEST(SignErrorOnTrial, IsCaughtByTheHiddenTruth) {
  const RunResult result =
      RunScenario(ReadScenario("examples/external_sign_error.yaml"));

  EXPECT_FALSE(result.passed);
  EXPECT_FALSE(result.lost);
  EXPECT_EQ(result.outcome, "diverges");
}

}  // namespace
}  // namespace caltwin

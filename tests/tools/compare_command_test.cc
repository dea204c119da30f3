#include <filesystem>

#include <CLI/Error.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "sim/base/text_file.h"
#include "tests/tools/run_command.h"
#include "tools/commands/command.h"

namespace caltwin {
namespace {

using testing::HasSubstr;

TEST(CompareCommand, PrintsALineForEveryEngine) {
  const Answer answer = RunCommand(DeclareCompare, {"delta", "--machines", "1"});

  EXPECT_EQ(answer.exit_code, kPassed);
  EXPECT_THAT(answer.out, HasSubstr("1 random deltas, seed 1"));
  for (const char* engine :
       {"g33 ", "rrf_least_squares", "klipper_descent", "delta_joint"}) {
    EXPECT_THAT(answer.out, HasSubstr(engine));
  }
}

TEST(CompareCommand, JsonOnADashStandsAlone) {
  const Answer answer =
      RunCommand(DeclareCompare, {"delta", "--machines", "1", "--json", "-"});

  EXPECT_EQ(nlohmann::json::parse(answer.out)["machines"], 1);
}

TEST(CompareCommand, WritesItsJsonBesideTheTable) {
  const auto file = std::filesystem::path(testing::TempDir()) / "compare_delta.json";

  const Answer answer =
      RunCommand(DeclareCompare,
                 {"delta", "--machines", "1", "--seed", "7", "--json", file.string()});

  EXPECT_THAT(answer.out, HasSubstr("seed 7"));
  EXPECT_EQ(nlohmann::json::parse(ReadTextFile(file, 100000))["seed"], 7);
  std::filesystem::remove(file);
}

TEST(CompareCommand, RefusesWhatItCannotCompare) {
  EXPECT_THROW(RunCommand(DeclareCompare, {"printers"}), CLI::ValidationError);
  EXPECT_THAT(
      RunCommand(DeclareCompare, {"delta", "--machine", "measured", "--machines", "5"})
          .fault,
      HasSubstr("--draws"));
  EXPECT_THROW(RunCommand(DeclareCompare, {"delta", "--machines", "0"}),
               CLI::ValidationError);
}

}  // namespace
}  // namespace caltwin

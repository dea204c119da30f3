// `caltwin diagnose --closed-loop` as a person uses it.
#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "sim/base/text_file.h"
#include "sim/measure/rows.h"
#include "tests/tools/run_command.h"
#include "tools/commands/command.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr std::size_t kMostBytes = 1 << 22;

class ClosedLoopCommand : public ::testing::Test {
 protected:
  ClosedLoopCommand() { fs::create_directories(folder_); }
  ~ClosedLoopCommand() override { fs::remove_all(folder_); }

  std::string File(const std::string& name) const { return (folder_ / name).string(); }

  /// `caltwin diagnose WORDS...`: what it prints.
  static std::string Diagnose(const std::vector<std::string>& words) {
    return Printed(DeclareDiagnose, words);
  }
  static std::string FaultOf(const std::vector<std::string>& words) {
    return RunCommand(DeclareDiagnose, words).fault;
  }

 private:
  fs::path folder_ = fs::temp_directory_path() /
                     (std::string("closed_loop_") +
                      ::testing::UnitTest::GetInstance()->current_test_info()->name());
};

TEST_F(ClosedLoopCommand, MeasuresByItselfAndRecordsEveryRow) {
  WriteTextFile(File("truth.yaml"), "effects:\n  backlash.x: {gap_mm: 0.02}\n");

  const std::string text =
      Diagnose({"--closed-loop",
                "twin:gantry_router?fidelity=fast&truth=" + File("truth.yaml"),
                "--record",
                File("all.csv"),
                "--json",
                File("answer.json"),
                "--replay",
                "none"});

  const auto answer =
      nlohmann::json::parse(ReadTextFile(File("answer.json"), kMostBytes));
  EXPECT_THAT(text, HasSubstr("Round 1: iso230, "));
  EXPECT_EQ(answer["verdict"], "none");
  ASSERT_EQ(answer["rounds"].size(), 1U);
  EXPECT_EQ(answer["rounds"][0]["rows"], ReadRows(File("all.csv")).rows.size());
  EXPECT_TRUE(answer["replay"].is_null());
  EXPECT_THAT(Diagnose({File("all.csv"), "--replay", "none"}),
              HasSubstr("Verdict: none."));
}

TEST_F(ClosedLoopCommand, RefusesWhatCannotMeasure) {
  EXPECT_THAT(FaultOf({"--closed-loop", "tcp:localhost:8023"}),
              HasSubstr("'tcp:localhost:8023' cannot measure campaigns"));
  EXPECT_THAT(FaultOf({"--closed-loop", "gantry_router"}),
              HasSubstr("'gantry_router' is no machine"));
  EXPECT_THAT(FaultOf({}), HasSubstr("no rows to diagnose"));
}

TEST_F(ClosedLoopCommand, DoesNotRecordOverTheTruth) {
  WriteTextFile(File("data.yaml"), "effects: {}\n");

  EXPECT_THAT(FaultOf({"--closed-loop",
                       "twin:gantry_router?truth=" + File("data.yaml"),
                       "--record",
                       File("data.csv")}),
              HasSubstr("which is read: it would be written over"));
}

}  // namespace
}  // namespace caltwin

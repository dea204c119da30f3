// `caltwin study` as a person uses it: parts, merging, aggregates, refusals.

#include <chrono>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/text_file.h"
#include "tests/base/temp_folder.h"
#include "tests/tools/run_command.h"
#include "tools/commands/command.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr std::size_t kMost_bytes = 1'000'000;

class StudyCommandTest : public ::testing::Test {
 protected:
  StudyCommandTest() {
    std::ofstream(folder_ / "plan.yaml")
        << "format: 1\nmachine: gantry_router\n"
           "instruments: {laser: {kind: laser, sigma_um: 1}}\n"
           "campaigns:\n  - iso230: {axis: x, positions: 5, runs: 1}\n";
  }

  Answer Run(const std::string& keys, std::vector<std::string> words) const {
    std::ofstream(folder_ / "study.yaml")
        << "study:\n  plan: plan.yaml\n"
           "  vary: {backlash.x.gap_mm: {normal: {mean: 0.05, sd: 0.01}}}\n"
        << keys;
    words.insert(words.begin(), (folder_ / "study.yaml").string());
    return RunCommand(DeclareStudy, words);
  }
  std::string In(const std::string& name) const { return (folder_ / name).string(); }
  std::string Text(const std::string& name) const {
    return ReadTextFile(folder_ / name, kMost_bytes);
  }

 private:
  TempFolder folder_{};
};

TEST_F(StudyCommandTest, PartsMergeIntoTheWhole) {
  const std::string keys = "  trials: 9\n";
  EXPECT_EQ(Run(keys, {"--out", In("whole")}).exit_code, kPassed);
  for (const std::string part : {"1/2", "2/2"}) {
    const Answer done =
        Run(keys, {"--shard", part, "--out", In("part" + part.substr(0, 1))});
    EXPECT_EQ(done.exit_code, kPassed) << done.fault;
  }
  const Answer merged =
      Run(keys, {"--merge", In("part2"), In("part1"), "--out", In("merged")});

  EXPECT_EQ(merged.exit_code, kPassed) << merged.fault;
  EXPECT_EQ(Text("merged/trials.csv"), Text("whole/trials.csv"));
  EXPECT_EQ(Text("merged/summary.json"), Text("whole/summary.json"));
}

TEST_F(StudyCommandTest, OfAPlanSaysWhatItTellsAndWhatToAdd) {
  const Answer answer = Run("  trials: 60\n  fidelity: linear\n",
                            {"--out", In("out"), "--report", In("report")});

  EXPECT_EQ(answer.exit_code, kPassed) << answer.fault;
  EXPECT_THAT(
      answer.out,
      AllOf(HasSubstr("This plan tells backlash.x"),
            HasSubstr("The best one to add: iso230"),
            HasSubstr("Linear against the closed forms, errors of 1000 machines")));
  EXPECT_FALSE(fs::exists(In("out/trials.csv")));  // None is kept.
  EXPECT_THAT(Text("report/index.html"), HasSubstr("backlash.x"));
}

constexpr const char* kLinear = "  trials: 60\n  fidelity: linear\n";

// A part is not checked by itself: it may be one machine.
TEST_F(StudyCommandTest, PartsOfALinearStudyMerge) {
  const std::string keys = std::string(kLinear) + "  keep: all\n";
  EXPECT_EQ(Run(keys, {"--out", In("whole")}).exit_code, kPassed);
  for (const std::string part : {"1/2", "2/2"}) {
    const Answer done =
        Run(keys, {"--shard", part, "--out", In("part" + part.substr(0, 1))});
    EXPECT_EQ(done.exit_code, kPassed) << done.fault;
  }
  const Answer merged =
      Run(keys, {"--merge", In("part2"), In("part1"), "--out", In("merged")});

  EXPECT_EQ(merged.exit_code, kPassed) << merged.fault;
  EXPECT_EQ(Text("merged/trials.csv"), Text("whole/trials.csv"));
}

TEST_F(StudyCommandTest, AnothersResultsAreNotOverwritten) {
  const std::string other = std::string(kLinear) + "  seed: 2\n";
  EXPECT_EQ(Run(kLinear, {"--out", In("out")}).exit_code, kPassed);
  const std::string before = Text("out/summary.json");

  EXPECT_THAT(Run(other, {"--out", In("out")}).fault, HasSubstr("of another study"));
  EXPECT_THAT(Run("  trials: 5\n", {"--out", In("out")}).fault,
              HasSubstr("of another study"));
  EXPECT_FALSE(fs::exists(In("out/study.sqlite")));
  EXPECT_EQ(Text("out/summary.json"), before);
  EXPECT_EQ(Run("  trials: 5\n", {"--out", In("kept")}).exit_code, kPassed);
  EXPECT_THAT(Run(kLinear, {"--out", In("kept")}).fault,
              HasSubstr("holds the trials of another study"));
}

TEST_F(StudyCommandTest, AFinishedStudyResumedChangesNothing) {
  const fs::file_time_type old(std::chrono::seconds(1'000'000));
  for (const char* keys : {kLinear, "  trials: 5\n", "  trials: 5\n  keep: none\n"}) {
    fs::remove_all(In("out"));
    EXPECT_EQ(Run(keys, {"--out", In("out")}).exit_code, kPassed);
    for (const auto& file : fs::directory_iterator(In("out"))) {
      fs::last_write_time(file.path(), old);
    }
    const Answer again = Run(keys, {"--out", In("out"), "--resume"});

    EXPECT_EQ(again.exit_code, kPassed) << again.fault;
    for (const auto& file : fs::directory_iterator(In("out"))) {
      EXPECT_EQ(fs::last_write_time(file.path()), old) << file.path();
    }
  }
}

TEST_F(StudyCommandTest, WhatIsRefusedLeavesNothing) {
  const std::string keys = "  trials: 9\n";
  EXPECT_EQ(Run(keys, {"--shard", "1/2", "--out", In("part")}).exit_code, kPassed);

  EXPECT_THAT(Run(keys, {"--merge", In("part"), "--out", In("merged")}).fault,
              HasSubstr("trial 1 is in none of these folders"));
  EXPECT_FALSE(fs::exists(In("merged")));
}

TEST_F(StudyCommandTest, RefusesWhatDoesNotGoTogether) {
  const std::vector<std::string> shard = {"--shard", "1/2", "--out", In("out")};

  EXPECT_THAT(Run("  adaptive: {digits: 1}\n", shard).fault, HasSubstr("is adaptive"));
  EXPECT_THAT(Run("  trials: 5\n  keep: none\n", shard).fault,
              HasSubstr("keeps no trials"));
  EXPECT_THAT(Run("  trials: 5\n", {"--shard", "3/2"}).fault,
              HasSubstr("--shard '3/2' is not I/N"));
  EXPECT_THAT(Run("  trials: 5\n", {"--trial", "5"}).fault, HasSubstr("0 to 4"));
  EXPECT_THAT(Run("  adaptive: {digits: 1, most_trials: 25000}\n", {}).fault,
              HasSubstr("no whole number of batches"));
  EXPECT_THROW(Run("  trials: 5\n", {"--shard", "1/2", "--trial", "1"}), CLI::Error);
  EXPECT_FALSE(fs::exists(In("out")));
}

}  // namespace
}  // namespace caltwin

// `caltwin study` as a person uses it: parts, merging, aggregates, refusals.

#include <chrono>
#include <filesystem>
#include <fstream>

#include <CLI/Error.hpp>
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

constexpr const char* kGap =
    "  vary: {backlash.x.gap_mm: {normal: {mean: 0.05, sd: 0.01}}}\n";

class StudyCommandTest : public ::testing::Test {
 protected:
  StudyCommandTest() {
    std::ofstream(folder_ / "plan.yaml")
        << "format: 1\nmachine: gantry_router\n"
           "instruments: {laser: {kind: laser, sigma_um: 1}}\n"
           "campaigns:\n  - iso230: {axis: x, positions: 5, runs: 1}\n";
  }

  Answer Run(const std::string& keys,
             std::vector<std::string> words,
             const std::string& vary = kGap) const {
    std::ofstream(folder_ / "study.yaml") << "study:\n  plan: plan.yaml\n"
                                          << vary << keys;
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

TEST_F(StudyCommandTest, TellsAProgramHowFarItIs) {
  const Answer done = Run("  trials: 3\n", {"--out", In("out"), "--progress"});

  EXPECT_EQ(done.exit_code, kPassed) << done.fault;
  EXPECT_THAT(done.out, HasSubstr("{\"done\":3,\"all\":3}\n"));
}

TEST_F(StudyCommandTest, OfAPlanSaysWhatItTellsAndWhatToAdd) {
  const Answer answer = Run("  trials: 60\n  fidelity: linear\n",
                            {"--out", In("out"), "--report", In("report")});

  EXPECT_EQ(answer.exit_code, kPassed) << answer.fault;
  EXPECT_THAT(
      answer.out,
      AllOf(HasSubstr("The plan determines backlash.x"),
            HasSubstr("The best one to add: iso230"),
            HasSubstr("Linear against the closed forms, errors of 1000 machines")));
  EXPECT_FALSE(fs::exists(In("out/trials.csv")));  // None is kept.
  EXPECT_THAT(Text("report/index.html"), HasSubstr("backlash.x"));
}

constexpr const char* kLinear = "  trials: 60\n  fidelity: linear\n";

// The first part is checked for all, by machines of its own: it may be one itself.
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

// Aggregates are put together bit for bit, of a linear design and of a plan's machines.
TEST_F(StudyCommandTest, PartsThatKeepNoTrialsMergeIntoTheWhole) {
  for (const std::string keys : {kLinear, "  trials: 20\n  keep: none\n"}) {
    for (const char* old : {"whole", "part1", "part2", "part3", "merged"}) {
      fs::remove_all(In(old));
    }
    EXPECT_EQ(Run(keys, {"--out", In("whole"), "--workers", "2"}).exit_code, kPassed);
    for (const std::string part : {"1/3", "2/3", "3/3"}) {
      const Answer done =
          Run(keys, {"--shard", part, "--out", In("part" + part.substr(0, 1))});
      EXPECT_EQ(done.exit_code, kPassed) << done.fault;
    }
    EXPECT_NE(Text("part1/summary.json"), Text("whole/summary.json"));
    const Answer merged = Run(keys,
                              {"--merge",
                               In("part3"),
                               In("part1"),
                               In("part1"),  // Counted once.
                               In("part2"),
                               "--out",
                               In("merged")});

    EXPECT_EQ(merged.exit_code, kPassed) << merged.fault;
    EXPECT_EQ(Text("merged/summary.json"), Text("whole/summary.json"));
  }
}

TEST_F(StudyCommandTest, PartsThatKeepNoTrialsAreNotTakenForOthers) {
  const auto merge = [&](const std::string& keys, std::vector<std::string> parts) {
    parts.insert(parts.begin(), "--merge");
    for (std::size_t i = 1; i < parts.size(); ++i) parts[i] = In(parts[i]);
    parts.insert(parts.end(), {"--out", In("merged")});
    return Run(keys, parts).fault;
  };
  EXPECT_EQ(Run(kLinear, {"--shard", "1/2", "--out", In("one")}).exit_code, kPassed);
  EXPECT_EQ(Run(kLinear, {"--shard", "2/3", "--out", In("third")}).exit_code, kPassed);
  EXPECT_THAT(Run(kLinear, {"--shard", "2/2", "--out", In("one")}).fault,
              HasSubstr("holds part 1/2 of the study, not 2/2"));
  EXPECT_THAT(Run(kLinear, {"--out", In("one")}).fault,
              HasSubstr("holds part 1/2 of the study, not 1/1"));
  EXPECT_THAT(merge(kLinear, {"one"}), HasSubstr("part 2/2 is in none of these"));
  EXPECT_THAT(merge(kLinear, {"one", "third"}),
              HasSubstr("holds part 2/3, another folder one of 2"));
  EXPECT_THAT(merge(kLinear, {"one", "nowhere"}),
              AllOf(HasSubstr("nowhere/aggregates.json"), HasSubstr("is not there")));
  EXPECT_THAT(merge(std::string(kLinear) + "  seed: 2\n", {"one"}),
              HasSubstr("is of another study"));
  std::string half = Text("one/aggregates.json");
  half.resize(half.size() / 2);
  WriteTextFile(In("one/aggregates.json"), half);
  EXPECT_THAT(merge(kLinear, {"one"}), HasSubstr("is no part of a study"));
  EXPECT_FALSE(fs::exists(In("merged")));
}

// The phase of a wave anywhere on the circle: nothing straight about it. The first part
// says so, before it begins, and without it there is no whole.
TEST_F(StudyCommandTest, WhetherLinearIsGoodEnoughTheFirstPartSays) {
  const std::string wave =
      "  vary:\n"
      "    cyclic_lead.x.amplitude_um: {normal: {mean: 20, sd: 1}}\n"
      "    cyclic_lead.x.period_mm: 4\n"
      "    cyclic_lead.x.phase_deg: {uniform: {min: -180, max: 180}}\n";
  for (const char* keep : {"", "  keep: all\n"}) {
    const std::string keys = std::string(kLinear) + keep;
    const auto run = [&](const std::string& part) {
      return Run(keys, {"--shard", part + "/2", "--out", In(keep + part)}, wave);
    };
    EXPECT_THAT(run("1").fault, HasSubstr("linear is not good enough"));
    EXPECT_FALSE(fs::exists(In(keep + std::string("1"))));
    EXPECT_EQ(run("2").exit_code, kPassed);
  }
}

TEST_F(StudyCommandTest, AFinishedPartResumedIsAsItWas) {
  const std::vector<std::string> part = {
      "--shard", "1/2", "--out", In("part"), "--resume"};
  EXPECT_EQ(Run(kLinear, part).exit_code, kPassed);  // Nothing there yet: it begins.
  EXPECT_FALSE(fs::exists(In("part/unfinished.sqlite")));
  const std::string before = Text("part/summary.json");
  fs::remove(In("part/summary.json"));  // Killed before it was written.

  EXPECT_EQ(Run(kLinear, part).exit_code, kPassed);
  EXPECT_EQ(Text("part/summary.json"), before);
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

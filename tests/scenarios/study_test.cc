// A study's results depend on its files and its seed, and on nothing else.

#include "scenarios/study/study.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenarios/study/run.h"
#include "scenarios/study/summary.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

// Its files in a folder of its own, empty at the beginning.
class StudyTest : public ::testing::Test {
 protected:
  StudyTest()
      : folder_(fs::path(::testing::TempDir()) /
                ::testing::UnitTest::GetInstance()->current_test_info()->name()) {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    Write("gap.yaml",
          "machine: gantry_router\n"
          "fidelity: fast\n"
          "effects: {backlash.x: {gap_mm: 0.05}}\n"
          "instruments: {probe: {sigma_um: 1}}\n"
          "artefacts: {block: {type: block123, at_mm: [150, 150, 0], side: x}}\n"
          "calibrate:\n"
          "  - next_cluster_backlash: {axis: x, variant: corrected, repeats: 3}\n");
  }

  void Write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
  }
  Study Read(const std::string& keys) const {
    Write("study.yaml", "study:\n  scenarios: [gap.yaml]\n" + keys);
    return ReadStudy(folder_ / "study.yaml");
  }
  std::string FaultOf(const std::string& keys) const {
    try {
      Read(keys);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  const fs::path& folder() const { return folder_; }

 private:
  fs::path folder_;
};

constexpr const char* kVaried =
    "  vary: {backlash.x.gap_mm: {lognormal: {median: 0.05, factor: 2}}}\n"
    "  trials: 12\n";

std::string CsvOf(const Study& study, const fs::path& folder, int workers) {
  StudyStore store(folder, study, /*may_resume=*/false);
  RunStudy(study, {.workers = workers}, &store);
  return TrialsCsv(study, store);
}

TEST_F(StudyTest, VariesWhatItNamesAndNothingElse) {
  const Study study = Read(
      "  vary: {backlash.x.gap_mm: 0.08, bed_tilt.slope_x_mrad: 0.5,\n"
      "         settings.steps_per_mm.x: 808}\n"
      "  trials: 1\n");
  const TwinConfig config = MakeTwinConfig(study.cases.at(0).scenario);

  ASSERT_EQ(config.effects.size(), 2U);
  EXPECT_EQ(config.effects[0].values[0], 0.08);
  EXPECT_EQ(EffectAt(config.effects[1].effect).name, "bed_tilt");
  EXPECT_EQ(config.effects[1].values, (std::vector<double>{0.5, 0}));
  EXPECT_EQ(config.settings.steps_per_mm[0], 808);
}

TEST_F(StudyTest, SaysWhatItDoesNotKnowAndWhere) {
  EXPECT_THAT(FaultOf("  trials: 0\n"), HasSubstr("study.yaml:3:11"));
  EXPECT_THAT(
      FaultOf("  vary: {backlsh.x.gap_mm: 1}\n  trials: 1\n"),
      AllOf(HasSubstr("study.yaml:3:28"), HasSubstr("did you mean 'backlash'")));
  EXPECT_THAT(FaultOf("  vary: {backlash.x.gap_mm: 100}\n  trials: 1\n"),
              HasSubstr("study.yaml:3:29"));
  EXPECT_THAT(FaultOf("  vary: {backlash: 1}\n  trials: 1\n"),
              HasSubstr("names no parameter"));
  EXPECT_THAT(FaultOf("  compare: [no_such]\n  trials: 1\n"),
              HasSubstr("is no procedure"));
  EXPECT_THAT(FaultOf("  trials: 1\n  scenaros: [x]\n"), HasSubstr("scenaros"));
  Write("gap.yaml", "machine: gantry_router\ncalibrate: [next_all]\nsede: 1\n");
  EXPECT_THAT(FaultOf("  trials: 1\n"), HasSubstr("gap.yaml:3:1"));
}

TEST_F(StudyTest, OneWorkerOrThreeGiveTheSameBytes) {
  const Study study = Read(kVaried);
  const std::string one = CsvOf(study, folder() / "one", 1);

  EXPECT_THAT(one, HasSubstr("trial,seed,status,machine_time_s,touches,"));
  EXPECT_THAT(one, HasSubstr("backlash.x.injected"));
  EXPECT_EQ(std::ranges::count(one, '\n'), 13);
  EXPECT_EQ(one, CsvOf(study, folder() / "three", 3));
}

TEST_F(StudyTest, WhatWasLostIsDoneAgainAndNothingElse) {
  const Study study = Read(kVaried);
  const std::string undisturbed = CsvOf(study, folder() / "whole", 2);
  {
    StudyStore store(folder() / "parts", study, /*may_resume=*/false);
    for (const std::int64_t trial : {0, 1, 7}) {
      store.Add(KeptOf(RunTrial(study, 0, trial), 0, trial));
    }
  }
  StudyStore store(folder() / "parts", study, /*may_resume=*/true);
  EXPECT_EQ(store.Done().size(), 3U);
  EXPECT_EQ(RunStudy(study, {}, &store).done, 12);
  EXPECT_EQ(TrialsCsv(study, store), undisturbed);
  EXPECT_EQ(RunStudy(study, {}, &store).per_s, 0);  // Nothing left to do.
}

TEST_F(StudyTest, AFolderThatHoldsTrialsIsNotWrittenToUnasked) {
  const Study study = Read(kVaried);
  CsvOf(study, folder() / "out", 1);
  try {
    StudyStore(folder() / "out", study, /*may_resume=*/false);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("--resume"));
  }
  const Study other = Read("  trials: 12\n  seed: 2\n");
  EXPECT_THROW(StudyStore(folder() / "out", other, true), InputError);
  Write("no_study", "text");
  fs::create_directories(folder() / "bad");
  fs::rename(folder() / "no_study", folder() / "bad" / "study.sqlite");
  EXPECT_THROW(StudyStore(folder() / "bad", study, true), InputError);
  Write("file", "");
  EXPECT_THROW(StudyStore(folder() / "file", study, false), InputError);
}

TEST_F(StudyTest, ContendersMeetTheSameMachines) {
  const Study study = Read(
      "  compare:\n"
      "    - next_cluster_backlash: {axis: x, variant: corrected, repeats: 3}\n"
      "    - next_cluster_backlash: {axis: x, variant: corrected, repeats: 10}\n" +
      std::string(kVaried));
  ASSERT_EQ(study.cases.size(), 2U);
  StudyStore store(folder() / "out", study, /*may_resume=*/false);
  RunStudy(study, {.workers = 2}, &store);
  std::map<std::int64_t, std::set<double>> gaps;
  store.ForEach([&](const TrialResult& result) {
    for (const ParameterResult& parameter : result.parameters) {
      if (parameter.name == "backlash.x") {
        gaps[result.trial].insert(parameter.injected);
      }
    }
  });
  ASSERT_EQ(gaps.size(), 12U);
  for (const auto& [trial, of_both] : gaps) EXPECT_EQ(of_both.size(), 1U) << trial;
}

TEST_F(StudyTest, SumsUpWhatCameOut) {
  const Study study = Read(kVaried);
  StudyStore store(folder() / "out", study, /*may_resume=*/false);
  const auto keep = [&](std::int64_t trial, double error, std::optional<double> sd) {
    store.Add({.trial = trial,
               .status = "recovers",
               .position_error_after_mm = std::abs(error),
               .parameters = {{.name = "gap",
                               .unit = "mm",
                               .injected = 1,
                               .recovered = 1 + error,
                               .sd = sd}}});
  };
  keep(0, 0.125, 0.125);
  keep(1, -0.25, 0.125);  // Just beyond 1.96 sd.
  keep(2, 0.0625, std::nullopt);
  store.Add({.trial = 3, .status = "failed", .message = "why"});
  const StudySummary summary = SummaryOf(study, store);

  const CaseSummary& one = summary.cases.at(0);
  EXPECT_EQ(one.status.at("failed"), 1);
  ASSERT_EQ(one.parameters.size(), 1U);
  const ParameterSummary& gap = one.parameters[0];
  EXPECT_EQ(gap.identified.hits, 3);
  EXPECT_NEAR(gap.error.mean, -0.0625 / 3, 1e-15);
  EXPECT_EQ(gap.coverage95.hits, 1);
  EXPECT_EQ(gap.coverage95.cases, 2);
  EXPECT_NEAR(gap.rms_over_sd, std::sqrt((1 + 4) / 2.0), 1e-12);
  EXPECT_EQ(one.worst.at(0), 1);
}

// Hyndman and Fan's type 7 as R prints it for 1, 2, 4, 8.
TEST(Quantiles, HasTheQuantilesOfR) {
  const Quantiles spread = QuantilesOf({8, 1, 4, 2});
  EXPECT_EQ(spread.mean, 3.75);
  EXPECT_NEAR(spread.sd, 3.095695936834452, 1e-14);
  EXPECT_DOUBLE_EQ(spread.q025, 1.075);
  EXPECT_DOUBLE_EQ(spread.median, 3);
  EXPECT_DOUBLE_EQ(spread.q975, 7.7);
}

// Wilson 1927, as in Newcombe's table: 0 of 10 and 81 of 263.
TEST(RateOf, HasWilsonsInterval) {
  EXPECT_NEAR(RateOf(0, 10).high, 0.2775, 1e-4);
  EXPECT_EQ(RateOf(0, 10).low, 0);
  EXPECT_NEAR(RateOf(81, 263).low, 0.2553, 1e-4);
  EXPECT_NEAR(RateOf(81, 263).high, 0.3662, 1e-4);
}

}  // namespace
}  // namespace caltwin

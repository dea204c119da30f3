// Studies of plans: the linear design is what the joint estimate does, and says where
// it is not.

#include <cmath>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "scenarios/study/aggregate.h"
#include "scenarios/study/linear.h"
#include "scenarios/study/summary.h"
#include "scenarios/study/unkept.h"
#include "tests/base/temp_folder.h"

namespace caltwin {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class StudyPlanTest : public ::testing::Test {
 protected:
  StudyPlanTest() {
    Write("plan.yaml",
          "format: 1\nmachine: gantry_router\n"
          "instruments: {laser: {kind: laser, sigma_um: 1}}\n"
          "campaigns:\n  - iso230: {axis: x, positions: 7, runs: 2}\n");
  }

  void Write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
  }
  Study Read(const std::string& keys) const {
    Write("study.yaml", "study:\n  plan: plan.yaml\n" + keys);
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

 private:
  TempFolder folder_{};
};

constexpr const char* kStraight =
    "  vary:\n"
    "    steps_per_mm.x.true_steps_per_mm: {normal: {mean: 800, sd: 0.1}}\n"
    "    backlash.x.gap_mm: {lognormal: {median: 0.05, factor: 1.2}}\n";

TEST_F(StudyPlanTest, TheDesignStatesWhatTheJointEstimateStates) {
  const Study study = Read(std::string(kStraight) + "  trials: 1\n");
  const RunResult fast = study.plan->Fast(0), linear = study.plan->Linear(0);

  ASSERT_EQ(fast.parameters.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(linear.parameters[i].name, fast.parameters[i].name);
    EXPECT_DOUBLE_EQ(linear.parameters[i].injected, fast.parameters[i].injected);
    // At another machine than the median one: straight to a thousandth.
    ASSERT_TRUE(linear.parameters[i].sd && fast.parameters[i].sd);
    EXPECT_NEAR(*linear.parameters[i].sd / *fast.parameters[i].sd, 1, 1e-3);
  }
}

// Closed form: means of 14 readings each way tell the gap, sqrt(2 / 14) of one's noise.
TEST_F(StudyPlanTest, TheGapScattersAsMeansOfReadingsDo) {
  const Study study =
      Read(std::string(kStraight) + "  trials: 4000\n  fidelity: linear\n");
  const StudySummary summary = SummaryOf(study, RunUnkept(study, {}));
  const ParameterSummary& gap = summary.cases.at(0).parameters.at(1);

  const double step_mm = 1.0 / 800;
  const double expected_mm = std::sqrt((1e-6 + step_mm * step_mm / 12) * 2 / 14);
  // The belief of 0.01 mm about the gap takes off less than a thousandth.
  EXPECT_EQ(gap.name, "backlash.x");
  EXPECT_NEAR(gap.error.sd / expected_mm, 1, 5 / std::sqrt(2.0 * 4000) + 1e-3);
  EXPECT_NEAR(gap.coverage95.rate, 0.95, 5 * std::sqrt(0.95 * 0.05 / 4000));
}

TEST_F(StudyPlanTest, OneWorkerOrThreeGiveTheSameBytes) {
  const Study study =
      Read(std::string(kStraight) + "  trials: 30000\n  fidelity: linear\n");
  const auto json = [&](int workers) {
    return SummaryJson(study, SummaryOf(study, RunUnkept(study, {.workers = workers})))
        .dump();
  };

  EXPECT_EQ(json(1), json(3));
  EXPECT_THAT(json(2), HasSubstr("\"fidelity\":\"linear\""));
}

TEST_F(StudyPlanTest, LinearAgreesWithTheClosedFormsWhereTheyAreStraight) {
  const Study study =
      Read(std::string(kStraight) + "  trials: 1\n  fidelity: linear\n");
  const LinearCheck check = CheckLinear(study, {});

  EXPECT_EQ(check.trials, 1000);  // Whatever the study has.
  ASSERT_EQ(check.unknowns.size(), 2U);
  EXPECT_NO_THROW(RequireLinear(study, check));
}

// A wave of 8 um whose phase may be off by 30 degrees: how far its phase is told
// depends on how large it is, which nothing straight has. The sd of the errors is 8 %
// off, which machines with noise of their own would let pass (10 %, and what chance
// leaves of 1000); of the same readings it is seen.
TEST_F(StudyPlanTest, WhatIsNotStraightShowsBeneathTheNoise) {
  Write("plan.yaml",
        "format: 1\nmachine: gantry_router\n"
        "instruments: {laser: {kind: laser, sigma_um: 5}}\n"
        "campaigns:\n  - iso230: {axis: x, positions: 7, runs: 2}\n");
  const Study study = Read(
      "  vary:\n"
      "    cyclic_lead.x.amplitude_um: {normal: {mean: 8, sd: 2}}\n"
      "    cyclic_lead.x.period_mm: 4\n"
      "    cyclic_lead.x.phase_deg: {uniform: {min: -30, max: 30}}\n"
      "  trials: 60\n  fidelity: linear\n");
  const LinearCheck check = CheckLinear(study, {});

  ASSERT_EQ(check.unknowns.size(), 2U);
  const LinearCheck::Unknown& phase = check.unknowns[1];
  EXPECT_FALSE(phase.agrees);
  EXPECT_LT(std::abs(phase.fast_sd / phase.linear_sd - 1), 0.15);
  EXPECT_LT(phase.difference_sd, 0.4 * phase.linear_sd);
}

// A switch that scatters as its maker says (1 um is what the design is told), and one
// that scatters by up to 1.25 um more: 1.2 times the noise.
TEST_F(StudyPlanTest, NoiseThatTheDesignIsNotToldIsRefused) {
  Write("plan.yaml",
        "format: 1\nmachine: gantry_router\n"
        "instruments: {probe: {kind: probe, sigma_um: 1}}\n"
        "campaigns:\n  - blocks: {points: 10, ways: 1}\n");
  const auto check = [&](const char* scatter) {
    const Study study = Read(
        std::string(
            "  vary:\n"
            "    steps_per_mm.x.true_steps_per_mm: {normal: {mean: 800, sd: 1}}\n") +
        scatter + "  trials: 60\n  fidelity: linear\n");
    return CheckLinear(study, {}).unknowns.at(0);
  };
  const LinearCheck::Unknown told = check("");
  EXPECT_TRUE(told.agrees);
  EXPECT_NEAR(told.noise_ratio, 1, 0.03);
  const LinearCheck::Unknown more =
      check("    trigger_scatter.sd_um: {uniform: {min: 0, max: 1.25}}\n");
  EXPECT_FALSE(more.agrees);
  EXPECT_GT(more.noise_ratio, 1.15);
}

// The phase of a wave anywhere on the circle: nothing straight about it.
TEST_F(StudyPlanTest, LinearIsRefusedWhereItMatters) {
  const Study study = Read(
      "  vary:\n"
      "    cyclic_lead.x.amplitude_um: {normal: {mean: 20, sd: 1}}\n"
      "    cyclic_lead.x.period_mm: 4\n"
      "    cyclic_lead.x.phase_deg: {uniform: {min: -180, max: 180}}\n"
      "  trials: 60\n  fidelity: linear\n");
  try {
    RequireLinear(study, CheckLinear(study, {}));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(),
                AllOf(HasSubstr("linear is not good enough for cyclic_lead.x"),
                      HasSubstr("fidelity: fast")));
  }
}

TEST_F(StudyPlanTest, SaysWhatAPlanCannotHave) {
  EXPECT_THAT(FaultOf("  trials: 1\n"), HasSubstr("nothing is varied"));
  EXPECT_THAT(FaultOf(std::string(kStraight) + "  trials: 1\n  fidelity: physics\n"),
              HasSubstr("is not known of a plan"));
  EXPECT_THAT(FaultOf("  vary: {settings.steps_per_mm.x: 808}\n  trials: 1\n"),
              HasSubstr("names more than effects"));
}

TEST_F(StudyPlanTest, AggregatesAreTheSummaryOfKeptTrials) {
  const Study study = Read(std::string(kStraight) + "  trials: 50\n");
  const TempFolder folder;
  StudyStore store(folder / "kept", study, true);
  RunStudy(study, {}, &store);
  const CaseSummary kept = SummaryOf(study, store).cases.at(0);
  Aggregate aggregate;
  RunTrials(study, {.workers = 2}, {}, [&](const TrialResult& result) {
    aggregate.Add(result);
  });
  const CaseSummary streamed = aggregate.Summary(study.cases.at(0));

  EXPECT_EQ(streamed.status, kept.status);
  ASSERT_EQ(streamed.parameters.size(), kept.parameters.size());
  for (std::size_t i = 0; i < kept.parameters.size(); ++i) {
    const ParameterSummary &one = streamed.parameters[i], &other = kept.parameters[i];
    EXPECT_EQ(one.name, other.name);
    EXPECT_EQ(one.coverage95.hits, other.coverage95.hits);
    EXPECT_NEAR(one.error.mean, other.error.mean, 1e-12 * other.error.sd);
    EXPECT_NEAR(one.error.sd, other.error.sd, 1e-9 * other.error.sd);
    // Half a part of 1/128, and half a gap between two of 50 in the tail.
    EXPECT_NEAR(one.error.median, other.error.median, 0.1 * other.error.sd);
  }
}

// Two blocks of 8192 trials are done, and then as many more; the last is a short one.
TEST_F(StudyPlanTest, LinearGoesOnToTheSameBytes) {
  Study study = Read(std::string(kStraight) + "  fidelity: linear\n  trials: 30000\n");
  const auto no_matter = [](const HalfDone&) {
  };
  HalfDone half;
  study.trials = 16384;
  RunLinear(study, {.workers = 2}, no_matter, &half);
  HalfDone read = HalfDone::OfText(half.Text());
  study.trials = 30000;
  std::int64_t done_first = -1;
  const StudyOptions options{.progress = [&](const StudyProgress& now) {
    if (done_first < 0) done_first = now.done;
  }};
  RunLinear(study, options, no_matter, &read);

  EXPECT_GE(done_first, 16384);
  EXPECT_EQ(read.aggregates.at(0).trials(), 30000);
  EXPECT_EQ(
      SummaryJson(study, SummaryOf(study, read.aggregates)).dump(),
      SummaryJson(study, SummaryOf(study, RunUnkept(study, {.workers = 3}))).dump());
}

// A plan leaves no position error; its worst machine is the one farthest off in sd.
TEST_F(StudyPlanTest, WorstIsWhereTheErrorIsMostOfItsUncertainty) {
  const Study study = Read(std::string(kStraight) + "  trials: 50\n");
  const TempFolder folder;
  StudyStore store(folder / "worst", study, true);
  RunStudy(study, {}, &store);
  Aggregate aggregate(/*is_of_plan=*/true);
  double largest_sd = 0;
  std::int64_t worst = -1;
  store.ForEach([&](const TrialResult& result) {
    aggregate.Add(result);
    for (const ParameterResult& one : result.parameters) {
      if (!(std::abs(*one.error) / *one.sd > largest_sd)) continue;
      largest_sd = std::abs(*one.error) / *one.sd;
      worst = result.trial;
    }
  });

  EXPECT_NE(worst, 0);  // Else the order of trials would pass as well.
  EXPECT_EQ(SummaryOf(study, store).cases.at(0).worst.at(0), worst);
  EXPECT_EQ(aggregate.Summary(study.cases.at(0)).worst.at(0), worst);
}

// Parameters come as the first trial has them, whichever trial ends first, and a unit
// of the first trial too: what workers and parts must not decide.
TEST(Aggregate, IsTheSameWhateverTheOrderAndTheParts) {
  const auto result = [](std::int64_t trial) {
    TrialResult one{.trial = trial,
                    .status = trial == 0 ? TrialResult::kFailed : "fitted",
                    .machine_time_s = 0.1 * static_cast<double>(trial),
                    .message = trial == 0 ? "why" : ""};
    const double error = 1.0 / static_cast<double>(trial + 3) - 0.1;
    if (trial > 1)
      one.parameters.push_back({.name = "late", .sd = 0.1, .error = error});
    one.parameters.push_back({.name = "gap", .unit = "mm", .error = error});
    return one;
  };
  Aggregate forward, backward, odd, even;
  for (std::int64_t trial = 0; trial < 9; ++trial) {
    forward.Add(result(trial));
    backward.Add(result(8 - trial));
    (trial % 2 == 0 ? even : odd).Add(result(trial));
  }
  Aggregate parts = Aggregate::OfJson(nlohmann::json::parse(even.ToJson().dump()));
  parts.Add(Aggregate::OfJson(nlohmann::json::parse(odd.ToJson().dump())));

  const auto text = [](const Aggregate& aggregate) {
    return SummaryJson({}, {.cases = {aggregate.Summary({})}}).dump();
  };
  EXPECT_EQ(forward.Summary({}).parameters.at(0).name, "gap");
  EXPECT_EQ(forward.Summary({}).status.at("failed"), 1);
  EXPECT_EQ(text(backward), text(forward));
  EXPECT_EQ(text(parts), text(forward));
}

TEST(Worst, KeepsTheGreatestWhateverTheOrder) {
  Worst forward, backward;
  for (std::int64_t trial = 0; trial < 10; ++trial) {
    forward.Add(static_cast<double>(trial % 7), trial);
    backward.Add(static_cast<double>((9 - trial) % 7), 9 - trial);
  }

  EXPECT_EQ(forward.trials(), (std::vector<std::int64_t>{6, 5, 4, 3, 2}));
  EXPECT_EQ(backward.trials(), forward.trials());
}

}  // namespace
}  // namespace caltwin

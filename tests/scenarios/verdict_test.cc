#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenarios/kinds/gantry_verdict.h"
#include "scenarios/parameter_name.h"
#include "sim/effects/catalog.h"

namespace caltwin {
namespace {

using ::testing::DoubleEq;
using ::testing::DoubleNear;
using ::testing::Eq;
using ::testing::IsEmpty;
using ::testing::Optional;
using ::testing::StrEq;

// A machine whose x is built with 800 steps/mm and a gap of 0.05 mm.
struct Bench {
  Machine machine{};
  std::vector<Injected> effects{
      {.effect = EffectIndex<Backlash>(), .axis = "x", .values = {0.05}}};
  GantryTruth trial{};

  Bench() {
    machine.settings.steps_per_mm.fill(800);
    trial.machine = &machine;
    trial.effects = &effects;
    trial.before.steps_per_mm.fill(800);
    trial.after = trial.before;
  }
};

Step Applied(const std::string& name, double before, double after) {
  return {.procedure = "p",
          .name = name,
          .before = before,
          .after = after,
          .verdict = Verdict::kApplied};
}

Estimate Told(const std::string& name, double value, double sd, bool is_setting) {
  return {.name = name,
          .value = value,
          .sd = sd,
          .identifiable = true,
          .is_setting = is_setting};
}

const ParameterResult& RowOf(const std::vector<ParameterResult>& table,
                             const std::string& name) {
  return *std::ranges::find(table, name, &ParameterResult::name);
}

// As the runner does it.
RunResult Judged(const GantryTruth& trial, const Expectation& expect = {}) {
  RunResult result{.parameters = MakeTable(trial, expect)};
  const bool all_met = MeetExpectations(expect, &result);
  const TrueEnd end = EndOfGantry(trial, result.parameters);
  result.outcome = JudgeOutcome(trial.results, end, all_met);
  CheckParameters(expect, trial.results, &result);
  for (const FigureExpectation& figure : expect.figures) {
    CheckFigure(figure, trial.position_error_after_mm, &result);
  }
  CheckMessages(expect.messages, trial.results, &result);
  CheckOutcome(expect.outcome, &result);
  return result;
}

std::vector<ParameterResult> TableOf(const GantryTruth& trial,
                                     const Expectation& expect) {
  return Judged(trial, expect).parameters;
}

std::string OutcomeOf(const GantryTruth& trial, const Expectation& expect = {}) {
  return Judged(trial, expect).outcome;
}

TEST(Verdict, ComparesTheSettingWithWhatWasBuilt) {
  Bench bench;
  bench.trial.after.backlash_mm[0] = 0.048;
  bench.trial.results = {{.steps = {Applied("backlash.x", 0, 0.048)},
                          .estimates = {Told("backlash.x", 0.048, 0.001, true)}}};
  const Expectation expect{
      .parameters = {{.name = "backlash.x", .truth_within = 0.003}}};

  const auto table = TableOf(bench.trial, expect);

  const ParameterResult& row = RowOf(table, "backlash.x");
  EXPECT_THAT(row.injected, DoubleEq(0.05));
  EXPECT_THAT(row.recovered, Optional(DoubleEq(0.048)));
  EXPECT_THAT(row.error, Optional(DoubleNear(-0.002, 1e-12)));
  EXPECT_THAT(row.passed, Optional(true));
  EXPECT_TRUE(row.is_setting);
}

TEST(Verdict, AnErrorBeyondItsToleranceFails) {
  Bench bench;
  bench.trial.after.backlash_mm[0] = 0.048;
  bench.trial.results = {{.steps = {Applied("backlash.x", 0, 0.048)},
                          .estimates = {Told("backlash.x", 0.048, 0.001, true)}}};
  const Expectation expect{
      .parameters = {{.name = "backlash.x", .truth_within = 0.001}}};

  EXPECT_THAT(RowOf(TableOf(bench.trial, expect), "backlash.x").passed,
              Optional(false));
  EXPECT_THAT(OutcomeOf(bench.trial, expect), StrEq("misses"));
}

TEST(Verdict, WhatWasMeasuredButNotAppliedIsAnEstimate) {
  Bench bench;
  bench.trial.results = {{.estimates = {Told("backlash.x", 0.051, 0.001, false)}}};

  const auto table = TableOf(bench.trial, {});

  EXPECT_THAT(RowOf(table, "backlash.x").recovered, Optional(DoubleEq(0.051)));
  EXPECT_FALSE(RowOf(table, "backlash.x").is_setting);
}

TEST(Verdict, AChangeRolledBackLeavesTheSettingAsRecovered) {
  Bench bench;
  bench.trial.after.backlash_mm[0] = 0.048;
  bench.trial.results = {{.steps = {Applied("backlash.x", 0, 0.048)},
                          .estimates = {Told("backlash.x", 0.048, 0.001, true)}},
                         {.estimates = {Told("backlash.x", 0.0600, 0.002, false)}}};

  const auto table = TableOf(bench.trial, {});

  EXPECT_THAT(RowOf(table, "backlash.x").recovered, Optional(DoubleEq(0.048)));
  EXPECT_THAT(RowOf(table, "backlash.x").sd, Optional(DoubleEq(0.001)));
  EXPECT_TRUE(RowOf(table, "backlash.x").is_setting);
}

TEST(Verdict, WhatCannotBeToldHasNoNumbers) {
  Bench bench;
  bench.trial.results = {{.estimates = {{.name = "probe_pretravel.z", .value = 3}}}};
  const Expectation expect{
      .parameters = {{.name = "probe_pretravel.z", .identifiable = false}}};

  const auto table = TableOf(bench.trial, expect);

  const ParameterResult& row = RowOf(table, "probe_pretravel.z");
  EXPECT_FALSE(row.identifiable);
  EXPECT_THAT(row.recovered, Eq(std::nullopt));
  EXPECT_THAT(row.sd, Eq(std::nullopt));
  EXPECT_THAT(row.error, Eq(std::nullopt));
  EXPECT_THAT(row.passed, Optional(true));
}

TEST(Verdict, AnExpectedTruthThatNobodyMeasuredFails) {
  const Bench bench;
  const Expectation expect{.parameters = {{.name = "backlash.y", .truth_within = 1}}};

  EXPECT_THAT(RowOf(TableOf(bench.trial, expect), "backlash.y").passed,
              Optional(false));
}

TEST(Verdict, InjectedAndNotMeasuredStaysInTheTable) {
  const Bench bench;

  const auto table = TableOf(bench.trial, {});

  EXPECT_THAT(RowOf(table, "backlash.x").recovered, Eq(std::nullopt));
  EXPECT_THAT(RowOf(table, "backlash.x").passed, Eq(std::nullopt));
}

TEST(Verdict, TwoGrowingPassesDivergeEvenIfALimitStoppedThem) {
  Bench bench;
  bench.trial.results = {{.ending = Ending::kRefused,
                          .steps = {Applied("steps_per_mm.x", 808, 816.1),
                                    Applied("steps_per_mm.x", 816.1, 832.5)}}};

  EXPECT_THAT(OutcomeOf(bench.trial), StrEq("diverges"));
}

// Whatever its passes say: the machine is worse than it was.
TEST(Verdict, AMachineThatErrsMoreThanBeforeDiverges) {
  Bench bench;
  bench.trial.position_error_before_mm = 0.5;
  bench.trial.position_error_after_mm = 1.0;
  bench.trial.results = {{.steps = {Applied("steps_per_mm.x", 808, 816.1)}}};
  EXPECT_THAT(OutcomeOf(bench.trial), StrEq("diverges"));

  bench.trial.position_error_after_mm = 0.5;
  EXPECT_THAT(OutcomeOf(bench.trial), StrEq("misses"));  // 16 steps/mm off.
}

TEST(Verdict, ASettingLeftWorseThanItWasMisses) {
  Bench bench;
  const auto end_at = [&](double backlash_mm) {
    bench.trial.after.backlash_mm[0] = backlash_mm;
    bench.trial.results = {
        {.steps = {Applied("backlash.x", 0, backlash_mm)},
         .estimates = {Told("backlash.x", backlash_mm, 0.002, true)}}};
    return OutcomeOf(bench.trial);
  };

  EXPECT_THAT(end_at(-0.05), StrEq("misses"));
  EXPECT_THAT(end_at(0.04), StrEq("misses"));  // Better than it was, but 5 sd off.
  EXPECT_THAT(end_at(0.045), StrEq("recovers"));
}

TEST(Verdict, WanderingWithinTheUncertaintyIsNoDivergence) {
  Bench bench;
  bench.trial.results = {{.steps = {Applied("steps_per_mm.x", 800, 800.01),
                                    Applied("steps_per_mm.x", 800.01, 800.02)},
                          .estimates = {Told("steps_per_mm.x", 800.02, 0.02, true)}}};

  EXPECT_THAT(OutcomeOf(bench.trial), StrEq("recovers"));
}

// A run that ends so has not recovered, whatever was done before.
TEST(Verdict, ARefusalEndsARun) {
  Bench bench;
  bench.trial.results = {{.ending = Ending::kRefused}};
  EXPECT_THAT(OutcomeOf(bench.trial), StrEq("refused"));

  bench.trial.results = {{.steps = {Applied("steps_per_mm.x", 808, 800)},
                          .estimates = {Told("steps_per_mm.x", 800, 0.01, true)}}};
  EXPECT_THAT(OutcomeOf(bench.trial), StrEq("recovers"));
  bench.trial.results.push_back({.ending = Ending::kRefused});
  EXPECT_THAT(OutcomeOf(bench.trial), StrEq("refused"));
}

TEST(Verdict, ZeroWhereThereIsAGapReadsZero) {
  Bench bench;
  bench.trial.results = {{.estimates = {Told("backlash.x", 0.0002, 0.001, false)}}};
  EXPECT_THAT(OutcomeOf(bench.trial), StrEq("reads_zero"));

  bench.effects[0].values[0] = 0.0005;  // No gap to speak of: zero is right.
  EXPECT_THAT(OutcomeOf(bench.trial), StrEq("recovers"));
}

struct EndingCase {
  Ending ending;
  const char* outcome;
};
class EveryEnding : public ::testing::TestWithParam<EndingCase> {};

TEST_P(EveryEnding, HasItsWord) {
  Bench bench;
  bench.trial.results = {{.ending = GetParam().ending}};

  EXPECT_THAT(OutcomeOf(bench.trial), StrEq(GetParam().outcome));
}

INSTANTIATE_TEST_SUITE_P(
    ,
    EveryEnding,
    ::testing::Values(EndingCase{Ending::kDone, "misses"},  // Nothing was told.
                      EndingCase{Ending::kNoTrigger, "no_trigger"},
                      EndingCase{Ending::kCollision, "collision"},
                      EndingCase{Ending::kAlarm, "alarm"},
                      EndingCase{Ending::kReadsZero, "reads_zero"},
                      EndingCase{Ending::kConfounded, "confounded"},
                      EndingCase{Ending::kRefused, "refused"}),
    [](const auto& test) { return std::string(test.param.outcome); });

TEST(Verdict, AnotherOutcomeThanExpectedFailsItsCheck) {
  Bench bench;
  bench.trial.results = {{.ending = Ending::kAlarm}};

  const auto checks = Judged(bench.trial).checks;

  ASSERT_THAT(checks.size(), Eq(1u));
  EXPECT_FALSE(checks[0].passed);
  EXPECT_THAT(checks[0].expected, StrEq("recovers"));
  EXPECT_THAT(checks[0].found, StrEq("alarm"));
}

TEST(Verdict, StepsMustComeInOrderAndNear) {
  Bench bench;
  bench.trial.results = {{.steps = {Applied("steps_per_mm.x", 808, 816.1),
                                    Applied("steps_per_mm.x", 816.1, 832.5)}}};
  Expectation expect{
      .parameters = {
          {.name = "steps_per_mm.x", .steps = {816, 832}, .steps_within = 1}}};
  const auto passed = [&] {
    return Judged(bench.trial, expect).checks.back().passed;
  };

  EXPECT_TRUE(passed());
  expect.parameters[0].steps = {832, 816};
  EXPECT_FALSE(passed());
  expect.parameters[0].steps = {816, 832, 866};
  EXPECT_FALSE(passed());
}

TEST(ParameterName, EveryNameLeadsBackToItself) {
  for (const std::string& name : AllParameterNames()) {
    EXPECT_TRUE(FindParameter(name).has_value()) << name;
  }
  EXPECT_FALSE(FindParameter("backlash").has_value());
  for (const std::string& name : SettingNames()) {
    EXPECT_TRUE(FindParameter(name).has_value()) << name;
  }
}

}  // namespace
}  // namespace caltwin

// A study's results depend on its files and its seed, and on nothing else.

#include "scenarios/study/study.h"

#include <cmath>
#include <filesystem>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "scenarios/kinds/gantry_trial.h"
#include "scenarios/kinds/motor_stage_scenario.h"
#include "scenarios/kinds/z_station_scenario.h"
#include "scenarios/study/aggregate.h"
#include "scenarios/study/run.h"
#include "scenarios/study/summary.h"
#include "scenarios/study/trials_csv.h"
#include "tests/scenarios/study_fixture.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

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

TEST_F(StudyTest, NamesOfParametersAreToldOnceAndWithTheirPlace) {
  const std::string fault = FaultOf("  vary: {backlash.q.gap_mm: 0.1}\n  trials: 1\n");
  EXPECT_THAT(fault, HasSubstr("study.yaml:3:10: study.vary.backlash.q"));
  EXPECT_THAT(FaultOf("  vary: {backlash.x.gap_mm: 100}\n  trials: 1\n"),
              HasSubstr("study.yaml:3:29: study.vary.backlash.x.gap_mm = 100 is"));
  EXPECT_THAT(FaultOf("  vary: {backlash.x.gapp_mm: 0.1}\n  trials: 1\n"),
              HasSubstr("study.yaml:3:10: study.vary.backlash.x"));
}

// The study of the contract: procedures by their names alone.
TEST_F(StudyTest, ContendersByTheirNamesAloneGetAnAxis) {
  Write("gap.yaml",
        "machine: gantry_router\nfidelity: fast\n"
        "effects: {backlash.y: {gap_mm: 0.05}}\n"
        "instruments: {probe: {sigma_um: 1}}\n"
        "artefacts: {block: {type: block123, at_mm: [150, 150, 0], side: y}}\n"
        "calibrate: [next_all]\n");
  const Study study = Read(
      "  vary: {backlash.y.gap_mm: {normal: {mean: 0.05, sd: 0.01}}}\n"
      "  compare: [next_cluster_backlash, trigger_release_backlash, next_all]\n"
      "  trials: 1\n");

  ASSERT_EQ(study.cases.size(), 3U);
  const auto told = [&](std::size_t of_case) {
    std::set<std::string> names;
    for (const ParameterResult& one : RunTrial(study, of_case, 0).parameters) {
      if (one.recovered) names.insert(one.name);
    }
    return names;
  };
  EXPECT_TRUE(told(1).contains("backlash.y"));
  EXPECT_FALSE(told(1).contains("backlash.x"));
  EXPECT_THAT(FaultOf("  compare: [dial_backlsh]\n  trials: 1\n"),
              HasSubstr("study.yaml:3:13"));
}

TEST_F(StudyTest, KeepsWhyARunEndedAndCountsByCause) {
  const RunResult stopped{.outcome = "no_trigger",
                          .parameters = {{.name = "backlash.x", .passed = false}},
                          .messages = {"something", "not found within 25.5 mm"}};
  const RunResult missed{
      .outcome = "misses",
      .parameters = {{.name = "backlash.x", .passed = false}, {.name = "tilt"}},
      .messages = {"something"}};
  const RunResult well{.outcome = "recovers", .messages = {"something"}};
  const Study study = Read(kVaried);
  StudyStore store(folder() / "out", study, /*may_resume=*/false);
  store.Add(KeptOf(stopped, 0, 0));
  store.Add(KeptOf(missed, 0, 1));
  store.Add(KeptOf(well, 0, 2));
  store.Add(KeptOf(stopped, 0, 3));
  const CaseSummary summary = SummaryOf(study, store).cases.at(0);

  EXPECT_EQ(summary.causes,
            (std::map<std::string, std::int64_t>{
                {"misses: missed backlash.x", 1},
                {"no_trigger: not found within #.# mm", 2}}));
  EXPECT_EQ(summary.touches.count, 4);  // All of them ran.
}

TEST_F(StudyTest, OneWorkerOrThreeGiveTheSameBytes) {
  const Study study = Read(kVaried);
  const std::string one = CsvOf(study, folder() / "one", 1);

  EXPECT_THAT(one, HasSubstr("trial,seed,status,machine_time_s,touches,"));
  EXPECT_THAT(one, HasSubstr("backlash.x.injected"));
  EXPECT_EQ(std::ranges::count(one, '\n'), 13);
  EXPECT_EQ(one, CsvOf(study, folder() / "three", 3));
}

TEST_F(StudyTest, VariesNoiseAndTheHysteresisAsBuilt) {
  const Study study = Read(
      "  vary: {instruments.probe.sigma_um: 3,\n"
      "         built.probe.hysteresis_mm: {normal: {mean: 0.002, sd: 0.0005}}}\n"
      "  trials: 2\n");
  const Scenario& scenario = study.cases.at(0).scenario;
  const TwinConfig first = MakeTwinConfig(scenario, {.sample = 0});
  const TwinConfig second = MakeTwinConfig(scenario, {.sample = 1});

  EXPECT_EQ(first.instruments.at("probe").sigma_um, 3);
  EXPECT_NE(first.machine.probe.hysteresis_mm, second.machine.probe.hysteresis_mm);
  EXPECT_NEAR(first.machine.probe.hysteresis_mm, 0.002, 5 * 0.0005);
  EXPECT_EQ(scenario.machine.machine.probe.hysteresis_mm, 0.002);
  EXPECT_THAT(FaultOf("  vary: {instruments.laser.sigma_um: 1}\n  trials: 1\n"),
              AllOf(HasSubstr("study.yaml:3:38"), HasSubstr("instruments.probe.")));
  EXPECT_THAT(FaultOf("  vary: {built.probe.colour: 1}\n  trials: 1\n"),
              HasSubstr("built.probe.hysteresis_mm"));
}

TEST_F(StudyTest, VariesTheAxesOfAMotorStage) {
  constexpr std::size_t kU = 4;
  Write("gap.yaml",
        "machine: motor_stage\n"
        "effects: {switch_scatter.u: {sd_um: 5}}\n"
        "calibrate:\n  - stepper_home: {axis: u}\n");
  const Study study = Read(
      "  vary: {switch_scatter.u.sd_um: 10,\n"
      "         start.u.at_mm: {uniform: {min: 30, max: 40}}}\n"
      "  trials: 2\n");
  const MotorStageTruth& motor =
      *study.cases.at(0).scenario.kind.As<MotorStageScenario>();
  const MotorFaults first = DrawMotorStage(motor, 1, 0).faults[kU];
  const MotorFaults second = DrawMotorStage(motor, 1, 1).faults[kU];

  EXPECT_DOUBLE_EQ(first.switch_scatter_unit, 0.01);
  EXPECT_NE(first.start_unit, second.start_unit);
  EXPECT_NEAR(first.start_unit, 35, 5);
  EXPECT_THAT(FaultOf("  vary: {switch_scater.u.sd_um: 1}\n  trials: 1\n"),
              AllOf(HasSubstr("study.yaml:3:33"), HasSubstr("'switch_scatter'")));
  EXPECT_THAT(FaultOf("  vary: {settings.steps_per_mm.x: 1}\n  trials: 1\n"),
              HasSubstr("is not known of this machine"));
}

TEST_F(StudyTest, VariesAStationForANozzlesHeight) {
  Write("gap.yaml",
        "machine: triple_z_printer\nfidelity: fast\n"
        "station: {plate_mm: 0.8, trigger_mm: 0.4}\n"
        "calibrate:\n  - z_calibration\n");
  const Study study = Read("  vary: {station.trigger_mm: 0.6}\n  trials: 1\n");
  ZStation station;
  SetStation(
      study.cases.at(0).scenario.kind.As<ZStationScenario>()->station, 1, 0, &station);

  EXPECT_EQ(station.trigger_mm, 0.6);
  EXPECT_EQ(station.plate_mm, 0.8);
  EXPECT_THAT(FaultOf("  vary: {station.colour_mm: 1}\n  trials: 1\n"),
              HasSubstr("colour_mm"));
}

TEST_F(StudyTest, ContendersMeetTheSameMachines) {
  const Study study = Read(
      "  compare:\n"
      "    - next_cluster_backlash: {axis: x, variant: corrected, repeats: 3}\n"
      "    - next_cluster_backlash: {axis: x, variant: corrected, repeats: 10}\n" +
      std::string(kVaried));
  ASSERT_EQ(study.cases.size(), 2U);
  EXPECT_THAT(study.cases[0].procedure, HasSubstr("repeats: 3"));
  EXPECT_THAT(study.cases[1].procedure, HasSubstr("repeats: 10"));
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

TEST_F(StudyTest, TheSameContenderTwiceIsRefused) {
  EXPECT_THAT(FaultOf("  compare: [next_all, next_all]\n  trials: 1\n"),
              AllOf(HasSubstr("study.yaml:3:"), HasSubstr("next_all' twice")));
}

TEST_F(StudyTest, SaysWhatIsNotDrawnAsWritten) {
  const Study study = Read(
      "  vary: {backlash.x.gap_mm: {normal: {mean: 0.05, sd: 0.05}}}\n  trials: 1\n");
  ASSERT_EQ(study.notes.size(), 1U);
  EXPECT_THAT(
      study.notes[0],
      AllOf(HasSubstr("study.yaml:3:"),
            HasSubstr("backlash.x.gap_mm: 16 % of what this draws is below 0")));
  EXPECT_THAT(SummaryText(study, {}), HasSubstr(study.notes[0]));
  EXPECT_EQ(SummaryJson(study, {})["notes"].size(), 1U);
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

// Of alike statements theirs, whether trials are kept or streamed; mixed ones by roots
// of mean squares and by sum u^4 / sum (u^4 / nu).
TEST_F(StudyTest, TakesStatedUncertaintiesTogether) {
  constexpr double kNormal = 1.959963984540054;
  const auto result = [](std::int64_t trial, double u, double k, double dof) {
    return TrialResult{
        .trial = trial,
        .status = "recovers",
        .parameters = {{.name = "gap",
                        .unit = "mm",
                        .recovered = 0.1,
                        .sd = k * u / kNormal,
                        .budget = {{.u = 0.6 * u, .dof = dof * 0.6 * 0.6},
                                   {.u = 0.8 * u, .dof = dof * 0.8 * 0.8}},
                        .error = 0.1}}};
  };
  // Shares of 0.36 and 0.64 with 0.36 and 0.64 of the freedom have all of it together.
  const std::vector<TrialResult> alike = {result(0, 0.5, 2.776, 4),
                                          result(1, 0.5, 2.776, 4)};
  std::vector<TrialResult> mixed = alike;
  mixed.push_back(result(2, 0.25, kNormal, std::numeric_limits<double>::infinity()));
  const Study study = Read(kVaried);
  for (const auto& [results, name] : {std::pair(alike, "alike"), {mixed, "mixed"}}) {
    StudyStore store(folder() / name, study, /*may_resume=*/false);
    Aggregate streamed;
    for (const TrialResult& one : results) {
      store.Add(one);
      streamed.Add(one);
    }
    const bool is_mixed = results.size() > 2;
    const double u = is_mixed ? std::sqrt((0.25 + 0.25 + 0.0625) / 3) : 0.5;
    const double U =
        is_mixed ? std::sqrt(
                       (2 * std::pow(2.776 * 0.5, 2) + std::pow(kNormal * 0.25, 2)) / 3)
                 : 2.776 * 0.5;
    const double dof = is_mixed ? 4 * (2 + std::pow(0.5, 4)) / 2 : 4;
    for (const CaseSummary& summary :
         {SummaryOf(study, store).cases.at(0), streamed.Summary(study.cases.at(0))}) {
      const Expanded& stated = summary.parameters.at(0).stated;
      EXPECT_NEAR(stated.u, u, 1e-12) << name;
      EXPECT_NEAR(stated.U, U, 1e-12) << name;
      EXPECT_NEAR(stated.k, U / u, 1e-12) << name;
      EXPECT_NEAR(stated.dof, dof, 1e-9) << name;
    }
  }
}

// Hyndman and Fan's type 7 as R prints it for 1, 2, 4, 8.
// Of an exponential distribution the shortest interval begins where it does; of one
// that is symmetric it is the symmetric one.
TEST(Quantiles, HaveTheShortestInterval) {
  std::vector<double> skewed, symmetric;
  for (int i = 0; i < 4000; ++i) {
    const double p = (i + 0.5) / 4000;
    skewed.push_back(-std::log(1 - p));
    symmetric.push_back(p < 0.5 ? std::log(2 * p) : -std::log(2 * (1 - p)));
  }
  const Quantiles one = QuantilesOf(skewed), other = QuantilesOf(symmetric);

  EXPECT_NEAR(one.shortest_low, 0, 1e-3);
  EXPECT_NEAR(one.shortest_high, -std::log(0.05), 0.01);
  EXPECT_NEAR(other.shortest_low, -other.shortest_high, 0.01);
  EXPECT_NEAR(other.shortest_high, -std::log(0.05), 0.01);
}

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

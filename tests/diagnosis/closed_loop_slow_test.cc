// A twin with a hidden defect, and a diagnosis that asks for what it needs.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/diagnosis/closed_loop.h"
#include "sim/effects/predict.h"
#include "sim/kinds/perform.h"
#include "sim/measure/in_force.h"

namespace caltwin {
namespace {

using ::testing::Contains;

Machine Gantry() {
  return ReadMachine("models/gantry_router/machine.yaml");
}

/// A defect, and the campaign that a person happened to begin with.
struct Start {
  std::string cause{};
  std::string axis{};
  double size = 0;
  std::string campaign{};
};

// Its baseline is off too, as every machine's.
std::vector<Injected> TruthOf(const Start& start) {
  const Machine machine = Gantry();
  std::vector<Injected> truth = {
      {.effect = EffectIndex<Backlash>(), .axis = "x", .values = {0.01}},
      {.effect = EffectIndex<StepsPerMm>(), .axis = "y", .values = {800.05}}};
  if (start.cause.empty()) return truth;
  truth.push_back(NeutralEffect(*FindEffect(start.cause), start.axis, machine));
  truth.back().values[0] = start.size;
  return truth;
}

Measurer MeasurerOf(const Start& start) {
  const std::vector<Injected> truth = TruthOf(start);
  return [truth](const MeasuredSession& session, std::size_t already_read) {
    return Perform({.machine = Gantry(),
                    .effects = truth,
                    .header = session.header,
                    .fidelity = Fidelity::kFast,
                    .seed = 1 + already_read,
                    .already_read = already_read},
                   session.table.rows);
  };
}

ClosedLoop LoopFrom(const Start& start) {
  const Machine machine = Gantry();
  const Plan plan = ReadPlanText(
      "seed: 3\n"
      "instruments: {laser: {kind: laser, sigma_um: 1, resolution_um: 0.1}, "
      "probe: {sigma_um: 1}, ballbar: {sigma_um: 1}}\n"
      "campaigns:\n  - " +
          start.campaign + "\n",
      "start.yaml");
  PlannedSession planned = PlanSession(plan, machine, plan.seed);
  MeasuredSession begun{.table = {.rows = planned.rows}, .header = planned.header};
  const Measurer measure = MeasurerOf(start);
  begun.table = measure(begun, 0);
  return MeasureUntilSettled(begun,
                             machine,
                             {},
                             measure,
                             {.settings = AsHeader(machine.settings, *machine.kind)});
}

TEST(ClosedLoop, TurnedPlateTellsASaggingGantryFromACurvedPlate) {
  const ClosedLoop loop =
      LoopFrom({"gantry_sag", "", 20, "plate: {probe_offset_mm: [0, 40]}"});

  ASSERT_GE(loop.rounds.size(), 2U);
  EXPECT_EQ(loop.rounds[0].verdict, DiagnosisVerdict::kAmbiguous);
  EXPECT_THAT(loop.rounds[0].candidates, Contains("gantry_sag"));
  EXPECT_THAT(loop.rounds[0].candidates, Contains("bed_cylinder.x"));
  EXPECT_EQ(loop.rounds[1].campaign, "plate_turned_90");
  EXPECT_EQ(loop.diagnosis.verdict, DiagnosisVerdict::kNamed);
  EXPECT_EQ(loop.diagnosis.findings[0].cause, "gantry_sag");
}

TEST(ClosedLoop, NothingIsAskedOfASoundMachine) {
  const ClosedLoop loop = LoopFrom({.campaign = "plate: {grid: [7, 7], repeats: 1}"});

  EXPECT_EQ(loop.rounds.size(), 1U);
  EXPECT_EQ(loop.diagnosis.verdict, DiagnosisVerdict::kNone);
}

// docs/closed-loop-diagnosis.md has the table that this prints.
TEST(ClosedLoop, ResolvesNearlyEveryAmbiguousStartAndNoneWrongly) {
  const std::vector<Start> starts = {
      {"gantry_sag", "", 30, "plate: {}"},
      {"gantry_sag", "", 60, "plate: {grid: [9, 5], repeats: 1}"},
      {"bed_cylinder", "x", 60, "plate: {}"},
      {"bed_cylinder", "y", 60, "plate: {}"},
      {"straightness", "EZY", 25, "plate: {}"},
      {"bed_twist", "", 40, "plate: {}"},
      {"probe_lobing", "", 8, "ring: {points: 36, spindle_deg: [0]}"},
      {"tip_runout", "", 15, "ring: {spindle_deg: [0, 180]}"},
      {"angular", "EBX", 150, "abbe: {}"},
      {"frame_temperature", "frame", 8, "drift: {warm_up_k: 10}"},
      {"cyclic_lead",
       "x",
       6,
       "iso230: {axis: x, regular: true, positions: 11, runs: 2}"},
      {"pitch_progressive", "x", 25, "ballbar: {}"}};
  int resolved = 0;
  int open = 0;
  for (const Start& start : starts) {
    const ClosedLoop loop = LoopFrom(start);
    const bool is_open = loop.rounds.front().verdict >= DiagnosisVerdict::kAmbiguous;
    const bool is_right = loop.diagnosis.verdict == DiagnosisVerdict::kNamed &&
                          loop.diagnosis.findings.size() == 1 &&
                          loop.diagnosis.findings[0].cause == start.cause &&
                          loop.diagnosis.findings[0].axis == start.axis;
    open += is_open ? 1 : 0;
    resolved += is_open && is_right ? 1 : 0;
    for (const LoopRound& round : loop.rounds) {
      GTEST_LOG_(INFO) << start.cause << " " << start.axis << ": " << RoundText(round);
    }
    EXPECT_TRUE(is_right || loop.diagnosis.verdict != DiagnosisVerdict::kNamed)
        << start.cause;
  }
  GTEST_LOG_(INFO) << resolved << " of " << open << " ambiguous starts resolved";
  constexpr double kLeastShare = 0.8;
  EXPECT_GE(open, 8);
  EXPECT_GE(resolved, kLeastShare * open);
}

}  // namespace
}  // namespace caltwin

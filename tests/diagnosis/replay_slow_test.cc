// Rows measured by a machine with a defect, taken again by its twin.
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/diagnosis/replay.h"
#include "calibration/diagnosis/volumetric.h"
#include "sim/effects/predict.h"
#include "sim/kinds/perform.h"
#include "sim/measure/plan.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;

constexpr double kSag_um = 30;
constexpr double kNoise_mm = 1e-3;

Machine Gantry() {
  return ReadMachine("models/gantry_router/machine.yaml");
}

// A plate and the same turned, touched by a machine that sags and has a gap.
Observed Sagging(double laid_higher_mm = 0) {
  const Plan plan = ReadPlanText(
      "instruments: {probe: {sigma_um: 1}}\n"
      "campaigns:\n"
      "  - plate: {grid: [5, 5], repeats: 1, probe_offset_mm: [0, 40]}\n"
      "  - plate_turned_90: {grid: [5, 5], repeats: 1}\n",
      "plan.yaml");
  PlannedSession planned = PlanSession(plan, Gantry(), 1);
  RowTable table = Perform(
      {.machine = Gantry(),
       .effects = {{.effect = EffectIndex<GantrySag>(),
                    .axis = "",
                    .values = {kSag_um}},
                   {.effect = EffectIndex<Backlash>(), .axis = "y", .values = {0.05}}},
       .header = planned.header},
      planned.rows);
  for (Row& row : table.rows) {
    if (row.campaign == "plate") row.value_mm += laid_higher_mm;
  }
  return {std::move(table), planned.header, Gantry(), {}};
}

Diagnosis Diagnosed(const Observed& observed) {
  return Diagnose(observed, {});
}

TEST(Replay, WhatWasFoundExplainsTheRowsInMuJoCoToTheNoise) {
  const Observed observed = Sagging();
  const Diagnosis diagnosis = Diagnosed(observed);
  ASSERT_EQ(diagnosis.findings.size(), 1U);

  const Replay replay = ReplayOf(observed, diagnosis, {});

  EXPECT_TRUE(replay.why_not.empty());
  EXPECT_FALSE(replay.is_generic_model);
  EXPECT_EQ(replay.rows, observed.num_rows());
  EXPECT_GT(replay.before_mm, 3 * kNoise_mm);
  // 4 standard deviations of the rms of that many rows.
  EXPECT_LT(replay.after_mm, kNoise_mm * (1 + 4 / std::sqrt(2.0 * replay.rows)));
  EXPECT_LT(replay.form_max_mm, kNoise_mm / 2);
  EXPECT_TRUE(replay.far_rows.empty());
}

TEST(Replay, AFindingOfTheWrongSignMakesItWorse) {
  const Observed observed = Sagging();
  Diagnosis diagnosis = Diagnosed(observed);
  ASSERT_EQ(diagnosis.findings.size(), 1U);
  diagnosis.findings[0].effect->values[0] *= -1;

  const Replay replay = ReplayOf(observed, diagnosis, {});

  EXPECT_GT(replay.after_mm, replay.before_mm);
}

TEST(Replay, WhereAPlateLiesIsFittedAndNotHeldAgainstTheTwin) {
  const Observed observed = Sagging(/*laid_higher_mm=*/0.3);

  const Replay replay = ReplayOf(observed, Diagnosed(observed), {});

  EXPECT_LT(replay.after_mm, 2 * kNoise_mm);
}

TEST(Replay, ManyRowsAreLeftAloneAndItSaysSo) {
  const Observed observed = Sagging();

  const Replay replay = ReplayOf(observed, Diagnosed(observed), {.most_rows = 10});

  EXPECT_THAT(ReplayText(replay), HasSubstr("75 rows, and more than 10 take long"));
  EXPECT_TRUE(ReplayJson(replay).is_null());
}

// A wave of amplitude A moves the tool by A / sqrt(2) rms, at most A; an amplitude
// known to s leaves s / sqrt(2).
TEST(VolumetricGain, OfAWaveIsItsRms) {
  constexpr double kAmplitude_um = 10, kSd_um = 0.5;
  const Observed observed = Sagging();
  Finding wave{.cause = "cyclic_lead", .axis = "x"};
  wave.effect = NeutralEffect(EffectIndex<CyclicLead>(), "x", Gantry());
  wave.effect->values[0] = kAmplitude_um;
  wave.sds = {kSd_um, 0, 0};
  const Diagnosis diagnosis{.verdict = DiagnosisVerdict::kNamed, .findings = {wave}};

  const auto gain = VolumetricGainOf(observed, diagnosis, 1);

  ASSERT_TRUE(gain);
  // sin^2 has variance 1/8; the rms is off by half of its relative error.
  const double tolerance = 4 * std::sqrt(1.0 / 8 / gain->poses);
  EXPECT_NEAR(gain->findings_mm * 1e3 / kAmplitude_um, std::sqrt(0.5), tolerance);
  EXPECT_NEAR(gain->after_mm * 1e3 / kSd_um, std::sqrt(0.5), tolerance);
  EXPECT_LE(gain->findings_max_mm, 1.2 * kAmplitude_um * 1e-3);
  EXPECT_DOUBLE_EQ(gain->before_mm, gain->findings_mm);
}

TEST(VolumetricGain, IsNotToldWhereNothingMovesTheTool) {
  const Observed observed = Sagging();
  Finding lobes{.cause = "probe_lobing"};
  lobes.effect = NeutralEffect(EffectIndex<ProbeLobing>(), "", Gantry());

  EXPECT_FALSE(VolumetricGainOf(
      observed, {.verdict = DiagnosisVerdict::kNamed, .findings = {lobes}}, 1));
}

}  // namespace
}  // namespace caltwin

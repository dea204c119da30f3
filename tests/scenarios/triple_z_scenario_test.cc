#include "scenarios/kinds/triple_z_scenario.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenarios/kinds/compare_levelling.h"
#include "scenarios/runner.h"
#include "sim/effects/catalog.h"

namespace caltwin {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

const std::filesystem::path kName = CALTWIN_SOURCE_DIR "/scenarios/in_a_test.yaml";

Scenario ReadText(const std::string& keys) {
  return ReadScenarioText("machine: triple_z_printer\nfidelity: fast\n" + keys, kName);
}

std::string FaultOf(const std::string& keys) {
  try {
    ReadText(keys);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(TripleZScenario, ASwapNeedsNoNumber) {
  const Scenario scenario = ReadText(
      "effects: {motors_swapped.z1z2: {}, pivot_position.z3: {dx_mm: 4}}\n"
      "calibrate: [plane_tilt]\n");

  const BuiltTripleZ built =
      DrawTripleZ(*scenario.kind.As<TripleZScenario>(), scenario.machine.machine, 1, 0);

  ASSERT_EQ(built.effects.size(), 2U);
  for (const Injected& effect : built.effects) {
    const bool is_swap = effect.effect == EffectIndex<MotorsSwapped>();
    EXPECT_DOUBLE_EQ(effect.values[0], is_swap ? 1 : 4);
  }
}

TEST(TripleZScenario, NamesWhatItCannotDo) {
  EXPECT_THAT(
      FaultOf("calibrate: [g33]\n"),
      HasSubstr("is a procedure of a delta, not of a triple-Z printer\n  there are "
                "plane_tilt, bed_tilt"));
  EXPECT_THAT(FaultOf("effects: {cyclic_lead.x: {amplitude_um: 5}}\ncalibrate: "
                      "[bed_tilt]\n"),
              HasSubstr("is no effect of a triple_z machine"));
  EXPECT_THAT(
      FaultOf("effects: {frame_growth: {growth_um: 5}}\ncalibrate: [bed_tilt]\n"),
      HasSubstr("'frame_growth' needs times or temperatures"));
  EXPECT_THAT(FaultOf("calibrate: [{bed_tilt: {offsets: formula}}]\n"),
              HasSubstr("offsets"));
}

// An option that a procedure does not heed would be ignored in silence.
TEST(TripleZScenario, OptionsThatAProcedureDoesNotHeedAreRefused) {
  for (const char* step : {"pivots_and_wiring: {grid: [5, 5]}",
                           "pivots_and_wiring: {at: screws}",
                           "pivots_and_wiring: {from: rounds, test_mm: 2}",
                           "bed_tilt: {test_mm: 2}",
                           "rrf_levelling: {variant: as_published, test_mm: 2}",
                           "plane_tilt: {largest_mm: 2}"}) {
    EXPECT_THAT(FaultOf("calibrate: [{" + std::string(step) + "}]\n"),
                HasSubstr("has no key"))
        << step;
  }
  EXPECT_THAT(FaultOf("calibrate: [{bed_tilt: {at: screws, grid: [5, 5]}}]\n"),
              HasSubstr("is not touched with `at: screws`"));
}

// Three touches over the screws of a bowl fit any plane; between them the bowl shows:
// b (r^2 / R^2 - 1) with b the corners' height over the middle.
TEST(TripleZScenario, HoldOutShowsWhatThreeTouchesCannot) {
  const Scenario scenario = ReadText(
      "effects: {bed_bowl: {height_um: 400}}\n"
      "calibrate: [{bed_tilt: {at: screws, hold_out: true}}]\n"
      "expect: {outcome: misses, validation_mm.mean: {below: 0.003}, "
      "hold_out_mm.mean: {above: 0.1}}\n");

  const RunResult result = RunScenario(scenario, {});

  EXPECT_TRUE(result.passed);
  EXPECT_THAT(result.messages, Contains(HasSubstr("hold-out: 4 points")));
}

TEST(TripleZScenario, MovesScrewsSinglyWithinTheirBounds) {
  const std::string beyond =
      "calibrate: [{move_triple_z: {at_mm: [120, 120], heights_mm: [240, 251, 240]}}]\n"
      "expect: {outcome: refused, messages: [\"z2 = 251 is outside 0 .. 250\"]}\n";
  const std::string within =
      "calibrate: [{move_triple_z: {at_mm: [120, 120], heights_mm: [240, 240.39, "
      "240]}}, plane_tilt]\n"
      "expect: {bed_tilt.slope_x_mrad: {truth_within: 3}}\n";

  EXPECT_TRUE(RunScenario(ReadText(beyond), {}).passed);
  const RunResult tilted = RunScenario(ReadText(within), {});
  // Screw 2 stands 195 mm along x from screw 1.
  ASSERT_FALSE(tilted.parameters.empty());
  EXPECT_NEAR(*tilted.parameters.front().recovered, 2.0, 0.02);
}

// Three motors have one wiring; two pairs of them always share one.
TEST(TripleZScenario, WhatNoMachineCanBeIsRefused) {
  EXPECT_THAT(FaultOf("effects: {motors_swapped.z1z2: {}, motors_swapped.z2z3: {}}\n"
                      "calibrate: [plane_tilt]\n"),
              HasSubstr("shares a motor with another pair"));
  EXPECT_THAT(FaultOf("settings: {screws_at_mm: {z2: [20, 20]}}\n"
                      "calibrate: [plane_tilt]\n"),
              HasSubstr("stand nearly in one line"));
  EXPECT_THAT(FaultOf("calibrate: [plane_tilt]\nexpect: {flatness_mm.rms: {}}\n"),
              HasSubstr("expects nothing"));
}

// Two rounds whose second is lost in noise tell no place; none is written into M671.
TEST(TripleZScenario, PlacesLostInNoiseAreNotWritten) {
  const Scenario scenario = ReadText(
      "effects: {bed_tilt: {slope_x_mrad: 3, slope_y_mrad: 2}, "
      "trigger_scatter: {sd_um: 20}}\n"
      "calibrate: [{pivots_and_wiring: {from: rounds}}]\n"
      "expect: {outcome: confounded}\n");
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    EXPECT_TRUE(RunScenario(scenario, {.seed = seed}).passed) << seed;
  }
}

// One round is foretold like five are.
TEST(TripleZScenario, OneIteratedRoundIsForetoldToo) {
  const Scenario scenario = ReadText(
      "effects: {bed_tilt: {slope_x_mrad: 3, slope_y_mrad: 2}, "
      "motors_swapped.z1z2: {}}\n"
      "calibrate: [{bed_tilt_iterated: {rounds: 1}}]\n"
      "expect: {outcome: refused}\n");
  EXPECT_TRUE(RunScenario(scenario).passed);
}

TEST(TripleZScenario, GridsAreWholeAndTimedAgainstThePublishedTimes) {
  EXPECT_THAT(FaultOf("calibrate: [{plane_tilt: {grid: [3.7, 2.2]}}]\n"),
              HasSubstr("is no pair of whole numbers"));
  const RunResult three = RunScenario(ReadText("calibrate: [plane_tilt]\n"), {});
  const RunResult five =
      RunScenario(ReadText("calibrate: [{plane_tilt: {grid: [5, 5]}}]\n"), {});

  EXPECT_THAT(three.messages, Contains(HasSubstr("s: as the published 15 to 20 s")));
  EXPECT_THAT(five.messages, Contains(HasSubstr("s: as the published 45 to 60 s")));
}

TEST(TripleZScenario, MovesBeyondTheLimitAreRefused) {
  const RunResult result =
      RunScenario(ReadText("effects: {bed_tilt: {slope_x_mrad: 20}}\n"
                           "calibrate: [{bed_tilt: {largest_mm: 1}}]\n"
                           "expect: {outcome: refused}\n"),
                  {});

  EXPECT_TRUE(result.passed);
  EXPECT_THAT(result.messages,
              Contains(HasSubstr("more than 1 (largest_mm): not done")));
  EXPECT_TRUE(result.steps.empty());
}

// A screw that does not answer as it is told: what validates worse is undone.
TEST(TripleZScenario, WhatValidatesWorseIsUndone) {
  const RunResult result =
      RunScenario(ReadText("effects: {bed_tilt: {slope_x_mrad: 3}, "
                           "motors_swapped.z1z2: {}}\n"
                           "calibrate: [bed_tilt]\nexpect: {outcome: misses}\n"),
                  {});

  ASSERT_FALSE(result.steps.empty());
  for (const Step& step : result.steps) {
    EXPECT_EQ(step.verdict, Verdict::kRolledBack);
    EXPECT_EQ(step.before, step.after);
  }
  EXPECT_NEAR(result.position_error_after_p95_mm,
              result.position_error_before_p95_mm,
              0.002);  // Whole steps of the screws.
}

TEST(TripleZScenario, TenLevellingsStayWhereTheFirstOneWas) {
  std::string steps;
  for (int i = 0; i < 10; ++i) steps += "  - bed_tilt: {}\n";
  const std::string keys =
      "effects: {bed_tilt: {slope_x_mrad: 3, slope_y_mrad: -5}}\ncalibrate:\n";

  const RunResult once = RunScenario(ReadText(keys + "  - bed_tilt: {}\n"), {});
  const RunResult ten = RunScenario(ReadText(keys + steps), {});

  // A step of the screws is 1.25 um.
  EXPECT_NEAR(
      ten.position_error_after_p95_mm, once.position_error_after_p95_mm, 0.0013);
}

// Of heights spread evenly over a slope of 3 mrad along 235 mm: 0.95 of half of it. Of
// a bowl of 0.4 mm, 0.4 (u^2 + v^2) / 2, by numbers; its mean, 0.133 mm, is no error.
TEST(TripleZScenario, PositionErrorIsThatOfTheNozzleOverTheBed) {
  const auto before_mm = [](const std::string& effects) {
    return RunScenario(ReadText("effects: {" + effects +
                                "}\ncalibrate: [plane_tilt]\n"
                                "expect: {outcome: recovers}\n"),
                       {.fidelity = Fidelity::kFast})
        .position_error_before_p95_mm;
  };

  EXPECT_NEAR(before_mm("bed_tilt: {slope_x_mrad: 3}"), 0.95 * 0.3525, 0.012);
  EXPECT_NEAR(before_mm("bed_bowl: {height_um: 400}"), 0.1535, 0.012);
  // Coming from either side the nozzle hangs by half the gap.
  EXPECT_NEAR(before_mm("backlash.z: {gap_mm: 0.1}"), 0.05, 1e-6);
}

// Touches as rows: what was told to every screw, and what the probe read.
TEST(TripleZScenario, RecordsItsTouches) {
  const Scenario scenario = ReadText(
      "effects: {bed_tilt: {slope_x_mrad: 2}}\n"
      "instruments: {probe: {sigma_um: 4}}\n"
      "calibrate:\n"
      "  - plane_tilt: {at: screws}\n"
      "  - move_triple_z: {at_mm: [120, 120], heights_mm: [240, 239.5, 240]}\n"
      "  - gcode: {lines: [\"G30 X215 Y20 S-1\", G28, \"G30 X215 Y20 S-1\"]}\n"
      "expect: {outcome: recovers}\n");
  const RunResult result = RunScenario(scenario, {});

  const std::vector<Row>& rows = result.rows.rows;
  ASSERT_EQ(rows.size(), 5U);
  constexpr double kScatter_mm = 4 * 0.004 + 0.00125;
  EXPECT_NEAR(rows[1].value_mm - rows[0].value_mm, 2e-3 * 195, 2 * kScatter_mm);
  EXPECT_EQ(rows[1].campaign, "plane_tilt");
  EXPECT_EQ(rows[1].cmd_mm, (std::array<double, 3>{215, 20, 0}));
  EXPECT_EQ(rows[1].motor_mm, (std::array<double, 3>{250, 250, 250}));
  // The second screw lower by half a millimetre, and level again after homing.
  EXPECT_EQ(rows[3].campaign, "gcode");
  EXPECT_EQ(rows[3].motor_mm, (std::array<double, 3>{250, 249.5, 250}));
  EXPECT_NEAR(rows[3].value_mm, rows[1].value_mm - 0.5, 2 * kScatter_mm);
  EXPECT_EQ(rows[4].motor_mm, (std::array<double, 3>{250, 250, 250}));
  EXPECT_NE(rows[4].home, rows[3].home);
  EXPECT_GT(rows[4].t_s, rows[3].t_s);
  EXPECT_EQ(result.header.instruments.at("probe").sigma_um, 4);
  EXPECT_EQ(result.header.settings.at(rows[4].settings).steps_per_mm.at("z"), 800);
  EXPECT_THAT(Unexplained(result.rows, result.header), ::testing::IsEmpty());
}

TEST(TripleZScenario, AnExternalProgramThatFailsIsTheOutcome) {
  const RunResult result =
      RunScenario(ReadText("calibrate:\n  - external: {command: [/bin/sh, -c, \"echo "
                           "M118 GAUGE laser.x; read a; echo $a >&2; exit 3\"]}\n"
                           "expect: {outcome: recovers}\n"),
                  {.fidelity = Fidelity::kFast});

  EXPECT_FALSE(result.passed);
  EXPECT_EQ(result.outcome, "refused");
  EXPECT_THAT(result.messages, Contains(HasSubstr("has no laser.x")));
}

TEST(CompareLevelling, ForetellsEveryLoopThatDiverges) {
  const LevellingComparison comparison = CompareLevelling(60, 3, [](int) {});

  EXPECT_GT(comparison.foretelling.diverging, 3);
  EXPECT_EQ(comparison.foretelling.foretold, comparison.foretelling.diverging);
  EXPECT_EQ(comparison.foretelling.false_alarms, 0);
  EXPECT_EQ(comparison.foretelling.swaps_named, comparison.foretelling.swapped);
  EXPECT_EQ(comparison.foretelling.swaps_invented, 0);
  EXPECT_LT(comparison.foretelling.pivot_mm.median, 0.5);
}

}  // namespace
}  // namespace caltwin

// The Cramer-Rao bounds by differences of simulated calibrations (FisherOfRuns) beside
// those in closed form (FisherOfTouches), and beside what the joint estimate states.

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/scenarios/fisher_of_runs.h"
#include "tests/scenarios/fisher_of_touches.h"

namespace caltwin {
namespace {

using F = FisherOfTouches;
constexpr double kSteps_per_mm = 800;

FisherOfRuns OfNext(const std::vector<TouchesOf>& touches) {
  return FisherOfRuns(
      {.study = "next.yaml",
       .touches = touches,
       .sigma_mm = 0.001,
       .step_mm = 1 / kSteps_per_mm,
       .unknowns = {{"steps_per_mm.x.true_steps_per_mm", kSteps_per_mm, 4},
                    {"steps_per_mm.y.true_steps_per_mm", kSteps_per_mm},
                    {"steps_per_mm.z.true_steps_per_mm", kSteps_per_mm},
                    {"backlash.x.gap_mm", 0.05, 0.02},
                    {"probe_pretravel.x.pretravel_mm", 0.02, 0.01},
                    {"tip_size.radius_error_mm", 0, 0.01, 0.001},
                    {"built.probe.hysteresis_mm", 0.002, 0.001, 0.0005},
                    {"trigger_latency.latency_ms", 10, 5}}});
}

// A block measures 25.4 and 76.2 mm and a ball 2: rounded to 27.4 and 78.2.
constexpr double kRoundedSpans = 0.01;

TEST(NextFisher, BoundsAreThoseOfFirstPrinciples) {
  F phase2, phases;
  AddPhase2(&phase2);
  AddPhases(&phases);
  AddKnown(&phase2);
  AddKnown(&phases);

  const FisherOfRuns of_phase2 = OfNext({{"dual_dimension.x", 40}});
  const FisherOfRuns of_phases =
      OfNext({{"dual_dimension.x", 40}, {"trigger_release.x"}, {"deflection.x", 20}});

  EXPECT_EQ(of_phase2.num_touches(), 40U);
  EXPECT_EQ(of_phases.num_touches(), 140U);
  EXPECT_NEAR(
      of_phase2.Bound("steps_per_mm.x") / (kSteps_per_mm * phase2.Bound(F::kScale)),
      1,
      kRoundedSpans);
  EXPECT_NEAR(of_phases.Bound("backlash.x") / phases.Bound(F::kGap), 1, kRoundedSpans);
  EXPECT_NEAR(of_phases.Bound("probe_pretravel.x") / phases.Bound(F::kPretravel),
              1,
              kRoundedSpans);
}

// The procedure sets steps by phase 2. All it touches would tell them twice as well,
// and the joint estimate of those rows says so (docs/coverage.md).
TEST(NextFisher, AllTouchesTellStepsTwiceAsWellAsPhase2) {
  const double of_phase2 = OfNext({{"dual_dimension.x", 40}}).Bound("steps_per_mm.x");
  const double of_all = OfNext({{"dual_dimension.x"},
                                {"trigger_release.x"},
                                {"backlash_check.x"},
                                {"deflection.x"},
                                {"verify.x"},
                                {"repeatability.x"}})
                            .Bound("steps_per_mm.x");
  const Scenario scenario = ReadScenarioText(
      "machine: gantry_router\nfidelity: fast\n"
      "effects: {backlash.x: {gap_mm: 0.05}}\n"
      "instruments: {probe: {sigma_um: 1}}\n"
      "artefacts: {block: {type: block123, at_mm: [150, 150, 0], side: x}}\n"
      "calibrate:\n"
      "  - next_all: {variant: corrected, repeats: 10, axes: [x]}\n"
      "  - joint_estimate: {axes: [x], measure: false, verify: false}\n",
      CALTWIN_SOURCE_DIR "/scenarios/in_a_test.yaml");
  const RunResult joint = RunScenario(scenario, {});
  const auto steps =
      std::ranges::find(joint.parameters, "steps_per_mm.x", &ParameterResult::name);

  EXPECT_GT(of_phase2 / of_all, 2);
  ASSERT_NE(steps, joint.parameters.end());
  // Beside what a setting kept adds, which is nothing of the touches.
  const auto readings =
      std::ranges::find(steps->budget, "readings", &Contribution::input);
  ASSERT_NE(readings, steps->budget.end());
  EXPECT_NEAR(readings->u / of_all, 1, kRoundedSpans);
}

}  // namespace
}  // namespace caltwin

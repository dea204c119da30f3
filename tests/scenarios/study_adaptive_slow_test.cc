// A whole adaptive study, and that it stops at the same trial when it is resumed.

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "scenarios/study/adaptive.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;

TEST(Adaptive, StopsAtTheSameTrialResumedOrNot) {
  const fs::path folder = fs::path(::testing::TempDir()) / "adaptive";
  fs::remove_all(folder);
  fs::create_directories(folder);
  std::ofstream(folder / "plan.yaml")
      << "format: 1\nmachine: gantry_router\n"
         "instruments: {laser: {kind: laser, sigma_um: 1}}\n"
         "campaigns:\n  - iso230: {axis: x, positions: 5, runs: 1}\n";
  std::ofstream(folder / "study.yaml")
      << "study:\n  plan: plan.yaml\n  fidelity: linear\n  keep: all\n"
         "  vary: {backlash.x.gap_mm: {normal: {mean: 0.05, sd: 0.01}}}\n"
         "  adaptive: {digits: 1, most_trials: 100000}\n";
  Study whole = ReadStudy(folder / "study.yaml"), resumed = whole;
  AdaptiveStop stop(1), stop_resumed(1);
  StudyStore store(folder / "whole", whole, /*may_resume=*/false);
  RunAdaptive(&whole, {.workers = 2}, &store, &stop);
  {
    StudyStore begun(folder / "parts", resumed, /*may_resume=*/false);
    for (const std::int64_t trial : {3, 11'000}) {
      begun.Add(KeptOf(RunTrial(resumed, 0, trial), 0, trial));
    }
  }
  StudyStore again(folder / "parts", resumed, /*may_resume=*/true);
  RunAdaptive(&resumed, {.workers = 1}, &again, &stop_resumed);

  EXPECT_TRUE(stop.IsSettled());
  EXPECT_EQ(whole.trials % kAdaptiveBatch, 0);
  EXPECT_GE(whole.trials, 2 * kAdaptiveBatch);
  EXPECT_LT(whole.trials, 100'000);
  EXPECT_EQ(resumed.trials, whole.trials);
  const auto state = stop.State(), state_resumed = stop_resumed.State();
  EXPECT_EQ(state.at("backlash.x").u, state_resumed.at("backlash.x").u);
}

}  // namespace
}  // namespace caltwin

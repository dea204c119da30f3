// What a motor stage's terminals show.

#include <cmath>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "tests/scenarios/motor_bench.h"

namespace caltwin {
namespace {

// Pulses begin at the encoder's edges, wherever between two of them the axis stood at
// power-up; what it counts from there are whole edges passed.
TEST(MotorStageRig, CountsTheEdgesItPasses) {
  for (const double part : {0.0, 0.4}) {
    BuiltMotorStage built = BuiltAsDrawn(DrawnMotorStage());
    built.faults[0].pulse_part = part;
    MotorStageRig rig(built, /*is_physics=*/false, 1, 0);
    const double pulse_mm = 1 / built.drawing.axes[0].pulses_per_unit();
    const auto count_after = [&](double pulses) {
      rig.MoveByHand(0, built.faults[0].start_unit + pulses * pulse_mm);
      return rig.Count(0);
    };

    EXPECT_EQ(count_after(0.3), 0);
    EXPECT_EQ(count_after(0.9 - part), 0);
    EXPECT_EQ(count_after(1.1 - part), 1);
    EXPECT_EQ(count_after(-0.1 - part), -1);
    EXPECT_EQ(count_after(7.5 - part), 7);
  }
}

// Each approach has a place of its own, also where they scatter by four times the
// switch's hysteresis: its mean, its standard deviation and no memory.
TEST(MotorStageRig, ASwitchClosesAtAPlaceOfItsOwnEachTime) {
  constexpr double kSigma_mm = 0.2, kStep_mm = 0.01;
  constexpr int kApproaches = 2000, kSteps = 120;  // From so many steps away.
  BuiltMotorStage built = BuiltAsDrawn(DrawnMotorStage());
  built.faults[0].switch_scatter_unit = kSigma_mm;
  MotorStageRig rig(built, /*is_physics=*/false, 1, 0);
  const double place_mm = built.drawing.axes[0].min_switch_unit;
  std::vector<double> closed_mm;
  for (int k = 0; k < kApproaches; ++k) {
    int steps = kSteps;
    while (!rig.IsPressed(0, SwitchEnd::kMin)) {
      --steps;
      rig.MoveByHand(0, place_mm + steps * kStep_mm);
    }
    closed_mm.push_back((steps + 0.5) * kStep_mm);
    for (; steps <= kSteps; ++steps) rig.MoveByHand(0, place_mm + steps * kStep_mm);
    EXPECT_FALSE(rig.IsPressed(0, SwitchEnd::kMin));
  }

  const double mean_mm = std::accumulate(closed_mm.begin(), closed_mm.end(), 0.0) /
                         static_cast<double>(kApproaches);
  double squares = 0, products = 0;
  for (std::size_t k = 0; k < closed_mm.size(); ++k) {
    squares += std::pow(closed_mm[k] - mean_mm, 2);
    if (k > 0) products += (closed_mm[k] - mean_mm) * (closed_mm[k - 1] - mean_mm);
  }
  const double sigmas = 4 / std::sqrt(kApproaches);
  EXPECT_NEAR(mean_mm, 0, sigmas * kSigma_mm + kStep_mm / 2);
  EXPECT_NEAR(std::sqrt(squares / kApproaches), kSigma_mm, sigmas * kSigma_mm);
  EXPECT_NEAR(products / squares, 0, sigmas);
}

// Wherever between two ticks the contact opens, what the controller tells is counted
// from there.
TEST(MotorStageStop, IsTimedFromWhenTheContactOpened) {
  constexpr std::size_t kX = 0;
  constexpr double kSpeed_mm_s = 200, kTick_s = 0.00025;
  for (const double part : {0.0, 0.2, 0.5, 0.9, 0.99}) {
    MotorBenchInATest bench(BuiltAsDrawn(DrawnMotorStage()), /*is_physics=*/true);
    bench.axes.SetZero(kX, 0);
    bench.axes.ArmRelay(0.2 + part * kTick_s);

    const auto moved = bench.axes.MoveTogether({kX}, 100, kSpeed_mm_s);
    const auto says = bench.axes.LastStop(kX);
    const auto stood_s = bench.watched.stood_s();

    ASSERT_FALSE(moved.has_value());
    ASSERT_TRUE(says && stood_s);
    EXPECT_NEAR(says->standstill_s, *stood_s, 10e-6) << part;
  }
}

}  // namespace
}  // namespace caltwin

#include "sim/controllers/klipper/step_queue.h"

#include <gtest/gtest.h>

#include "sim/base/rng.h"

namespace caltwin {
namespace klipper {
namespace {

TEST(KlipperClock, IsExtendedToTheNearest) {
  constexpr Clock kWrap = Clock{1} << 32;
  EXPECT_EQ(Extended(10, kWrap - 5), kWrap + 10);
  EXPECT_EQ(Extended(0xFFFFFFF0, kWrap + 5), kWrap - 16);
  EXPECT_EQ(Extended(7, 7), 7);
}

TEST(KlipperStepMove, StepsFallWhenTheClosedFormSays) {
  const StepMove move{.start = 1000, .interval = 100, .count = 4, .add = -10};
  // Intervals 100, 90, 80, 70.
  EXPECT_EQ(move.StepClock(1), 1100);
  EXPECT_EQ(move.StepClock(2), 1190);
  EXPECT_EQ(move.StepClock(3), 1270);
  EXPECT_EQ(move.end(), 1340);
  EXPECT_EQ(move.StepsDone(1099), 0);
  EXPECT_EQ(move.StepsDone(1100), 1);
  EXPECT_EQ(move.StepsDone(1269), 2);
  EXPECT_EQ(move.StepsDone(99'999), 4);
}

TEST(KlipperStepMove, CountsAsAMotorDrivenStepByStepDoes) {
  Rng rng(3, 0, "klipper.steps");
  for (int round = 0; round < 50; ++round) {
    const StepMove move{
        .start = 500,
        .interval = 2000 + static_cast<std::int64_t>(500 * rng.Uniform()),
        .count = 1 + static_cast<std::int64_t>(60 * rng.Uniform()),
        .add = static_cast<std::int64_t>(60 * rng.Uniform()) - 30};
    ASSERT_TRUE(move.IsOrdered());
    Clock falls = move.start;
    std::int64_t interval = move.interval;
    for (std::int64_t step = 1; step <= move.count; ++step, interval += move.add) {
      falls += interval;
      EXPECT_EQ(move.StepClock(step), falls);
      EXPECT_EQ(move.StepsDone(falls - 1), step - 1);
      EXPECT_EQ(move.StepsDone(falls), step);
    }
  }
}

TEST(KlipperStepQueue, GoesThereAndBack) {
  StepQueue queue;
  queue.Reset(1000);
  EXPECT_EQ(queue.Append(100, 10, 0, +1, 0), StepQueue::Fault::kNone);
  EXPECT_EQ(queue.Append(50, 4, 0, -1, 0), StepQueue::Fault::kNone);
  EXPECT_EQ(queue.At(0), 0);
  EXPECT_EQ(queue.At(1999), 9);
  EXPECT_EQ(queue.At(2000), 10);
  EXPECT_EQ(queue.At(2100), 8);
  queue.Forget(2100);
  EXPECT_EQ(queue.At(2100), 8);
  EXPECT_TRUE(queue.IsActive(2199));
  EXPECT_FALSE(queue.IsActive(2200));
  EXPECT_EQ(queue.At(9999), 6);
}

TEST(KlipperStepQueue, TellsWhereItTurnsRound) {
  StepQueue queue;
  queue.Append(100, 10, 0, +1, 0);
  queue.Append(100, 5, 0, +1, 0);
  queue.Append(100, 5, 0, -1, 0);
  queue.Append(100, 5, 0, +1, 0);
  std::vector<Clock> turns;
  queue.AppendTurns(0, 5000, &turns);
  EXPECT_EQ(turns, (std::vector<Clock>{1500, 2000}));
  turns.clear();
  queue.AppendTurns(1500, 1999, &turns);
  EXPECT_TRUE(turns.empty());
}

TEST(KlipperStepQueue, StandsWhereItIsStopped) {
  StepQueue queue;
  queue.Append(100, 10, 0, +1, 0);
  queue.Stop(350);
  EXPECT_EQ(queue.At(350), 3);
  EXPECT_EQ(queue.At(5000), 3);
  EXPECT_FALSE(queue.IsActive(350));
}

TEST(KlipperStepQueue, ClocksComeAroundAfterAnyRest) {
  constexpr Clock kNow = (Clock{5} << 32) + 12'345;
  StepQueue queue;
  queue.Append(100, 1, 0, +1, 0);
  // The host counts from step to step; 32 bits of the interval are all that is sent.
  const auto interval =
      static_cast<std::int64_t>(static_cast<std::uint32_t>(kNow + 1000 - 100));
  EXPECT_EQ(queue.Append(interval, 1, 0, +1, kNow), StepQueue::Fault::kNone);
  EXPECT_EQ(queue.At(kNow + 999), 1);
  EXPECT_EQ(queue.At(kNow + 1000), 2);
}

TEST(KlipperStepQueue, RefusesWhatHasPassed) {
  StepQueue queue;
  EXPECT_EQ(queue.Append(100, 1, 0, +1, 101), StepQueue::Fault::kTooClose);
  EXPECT_EQ(queue.Append(100, 1, 0, +1, 100), StepQueue::Fault::kNone);
  // Steps that would go back in time.
  EXPECT_EQ(queue.Append(100, 20, -10, +1, 100), StepQueue::Fault::kTooFarInPast);
}

}  // namespace
}  // namespace klipper
}  // namespace caltwin

#include "sim/firmware/planner.h"

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace caltwin {
namespace {

constexpr double kAsFastAsItGoes = std::numeric_limits<double>::infinity();

MotionLimits Limits() {
  return {.feed_mm_s = {100.0, 50.0, 10.0},
          .acceleration_mm_s2 = {500.0, 400.0, 100.0},
          .jerk_mm_s = Vec3<double>::Constant(10)};
}

/// Durations of moves along x [mm] at a feed, planned all at once.
std::vector<Segment> Plan(const std::vector<Vec3<double>>& moves_mm, double feed_mm_s) {
  MoveQueue queue(Limits());
  for (const Vec3<double>& delta_mm : moves_mm) {
    queue.Add(MakeMove(delta_mm, feed_mm_s, Limits()));
  }
  std::vector<Segment> segments;
  while (!queue.empty()) segments.push_back(queue.TakeFirst());
  return segments;
}

TEST(Planner, NoAxisExceedsItsOwnFeedOrAcceleration) {
  const PlannedMove move = MakeMove({30.0, 40.0, 0.0}, kAsFastAsItGoes, Limits());

  EXPECT_DOUBLE_EQ(move.feed_mm_s, 50 / 0.8);
  EXPECT_DOUBLE_EQ(move.acceleration_mm_s2, 400 / 0.8);
  EXPECT_DOUBLE_EQ(move.segment.profile.length_mm, 50);
}

TEST(Planner, LongMoveReachesItsFeed) {
  const auto segments = Plan({{100.0, 0.0, 0.0}}, 50);

  // v / a to speed up, the same to slow down, the rest at v: L / v + v / a.
  EXPECT_NEAR(segments[0].profile.Duration_s(), 100.0 / 50 + 50.0 / 500, 1e-12);
}

TEST(Planner, ShortMoveIsATriangle) {
  const auto segments = Plan({{2.0, 0.0, 0.0}}, 100);

  EXPECT_NEAR(segments[0].profile.Duration_s(), 2 * std::sqrt(2.0 / 500), 1e-12);
  EXPECT_NEAR(segments[0].profile.feed_top_mm_s, std::sqrt(500.0 * 2), 1e-12);
}

TEST(Planner, CollinearMovesBlendIntoOne) {
  const auto whole = Plan({{100.0, 0.0, 0.0}}, 50);
  const auto parts = Plan(std::vector<Vec3<double>>(50, {2.0, 0.0, 0.0}), 50);

  double duration_s = 0;
  for (const Segment& segment : parts) duration_s += segment.profile.Duration_s();
  EXPECT_NEAR(duration_s, whole[0].profile.Duration_s(), 1e-9);
}

TEST(Planner, FeedNeverJumpsBetweenMoves) {
  const auto segments = Plan({{5.0, 0.0, 0.0},
                              {0.3, 0.1, 0.0},
                              {0.1, 0.3, 0.0},
                              {0.0, 5.0, 0.0},
                              {-1.0, 0.0, 0.0}},
                             80);

  double feed_mm_s = 0;
  for (const Segment& segment : segments) {
    const Profile& p = segment.profile;
    EXPECT_DOUBLE_EQ(p.feed_in_mm_s, feed_mm_s);
    EXPECT_NEAR(p.Distance_mm(p.Duration_s() * (1 - 1e-9)), p.length_mm, 1e-6);
    EXPECT_GE(p.feed_top_mm_s, std::max(p.feed_in_mm_s, p.feed_out_mm_s));
    feed_mm_s = p.feed_out_mm_s;
  }
  EXPECT_EQ(feed_mm_s, 0);
}

TEST(Planner, RightAngleIsTakenAtTheJerkOfBothAxes) {
  const auto segments = Plan({{50.0, 0.0, 0.0}, {0.0, 50.0, 0.0}}, 40);

  // x loses v and y gains v at once: v = jerk.
  EXPECT_DOUBLE_EQ(segments[0].profile.feed_out_mm_s, 10);
}

TEST(Planner, ReversalIsTakenAtHalfTheJerk) {
  const auto segments = Plan({{50.0, 0.0, 0.0}, {-50.0, 0.0, 0.0}}, 40);

  EXPECT_DOUBLE_EQ(segments[0].profile.feed_out_mm_s, 5);
}

TEST(Planner, FeedOfAMoveTakenEarlyIsKeptByWhatFollows) {
  MoveQueue queue(Limits());
  queue.Add(MakeMove({10.0, 0.0, 0.0}, 50, Limits()));
  queue.Add(MakeMove({1.0, 0.0, 0.0}, 50, Limits()));
  const Segment first = queue.TakeFirst();
  queue.Add(MakeMove({10.0, 0.0, 0.0}, 50, Limits()));
  const Segment second = queue.TakeFirst();

  // Only 1 mm was left for braking when the first was taken: sqrt(2 a 1 mm).
  EXPECT_NEAR(first.profile.feed_out_mm_s, std::sqrt(2.0 * 500), 1e-12);
  EXPECT_DOUBLE_EQ(second.profile.feed_in_mm_s, first.profile.feed_out_mm_s);
  EXPECT_GT(second.profile.feed_out_mm_s, second.profile.feed_in_mm_s);
}

}  // namespace
}  // namespace caltwin

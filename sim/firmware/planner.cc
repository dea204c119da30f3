#include "sim/firmware/planner.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "sim/base/require.h"

namespace caltwin {
namespace {

/// Feed reached from `feed_mm_s` after `length_mm` of constant acceleration.
double FeedAfter_mm_s(double feed_mm_s, double acceleration_mm_s2, double length_mm) {
  return std::sqrt(feed_mm_s * feed_mm_s + 2 * acceleration_mm_s2 * length_mm);
}

/// The least of limit / |share| over the axes that take part.
double Tightest(const Vec3<double>& limit, const Vec3<double>& share) {
  double tightest = std::numeric_limits<double>::infinity();
  for (const Axis axis : kAxes) {
    const double part = std::abs(share[Index(axis)]);
    if (part > 1e-12) tightest = std::min(tightest, limit[Index(axis)] / part);
  }
  return tightest;
}

}  // namespace

PlannedMove MakeMove(const Vec3<double>& delta_mm,
                     double feed_mm_s,
                     const MotionLimits& limits) {
  PlannedMove move;
  const double length_mm = delta_mm.norm();
  Require(length_mm > 0 && feed_mm_s > 0, "a move has a length and a feed");
  move.along = delta_mm / length_mm;
  move.segment.profile.length_mm = length_mm;
  move.feed_mm_s = std::min(feed_mm_s, Tightest(limits.feed_mm_s, move.along));
  move.acceleration_mm_s2 = Tightest(limits.acceleration_mm_s2, move.along);
  return move;
}

double JunctionFeed_mm_s(const PlannedMove& before,
                         const PlannedMove& after,
                         const MotionLimits& limits) {
  return std::min(
      {before.feed_mm_s,
       after.feed_mm_s,
       Tightest(limits.jerk_mm_s, Vec3<double>(after.along - before.along))});
}

void MoveQueue::Add(PlannedMove move) {
  move.most_in_mm_s =
      moves_.empty() ? feed_now_mm_s_ : JunctionFeed_mm_s(moves_.back(), move, limits_);
  moves_.push_back(std::move(move));
}

Segment MoveQueue::TakeFirst() {
  Require(!moves_.empty(), "the queue holds a move");
  double braked_mm_s = 0;  // The feed at which the second move can still brake in time.
  for (std::size_t i = moves_.size(); i-- > 1;) {
    const PlannedMove& move = moves_[i];
    braked_mm_s = std::min(
        move.most_in_mm_s,
        FeedAfter_mm_s(
            braked_mm_s, move.acceleration_mm_s2, move.segment.profile.length_mm));
  }
  const PlannedMove first = std::move(moves_.front());
  moves_.pop_front();
  Segment segment = first.segment;
  Profile& profile = segment.profile;
  profile.acceleration_mm_s2 = first.acceleration_mm_s2;
  profile.feed_in_mm_s = feed_now_mm_s_;
  profile.feed_out_mm_s = std::min(
      braked_mm_s,
      FeedAfter_mm_s(feed_now_mm_s_, first.acceleration_mm_s2, profile.length_mm));
  const double peak_mm_s = std::sqrt(
      first.acceleration_mm_s2 * profile.length_mm +
      (std::pow(profile.feed_in_mm_s, 2) + std::pow(profile.feed_out_mm_s, 2)) / 2);
  profile.feed_top_mm_s = std::max({std::min(first.feed_mm_s, peak_mm_s),
                                    profile.feed_in_mm_s,
                                    profile.feed_out_mm_s});
  feed_now_mm_s_ = profile.feed_out_mm_s;
  return segment;
}

void MoveQueue::Clear() {
  moves_.clear();
  feed_now_mm_s_ = 0;
}

}  // namespace caltwin

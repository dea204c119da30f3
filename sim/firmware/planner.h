#pragma once

#include <deque>

#include "sim/firmware/plant.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// What limits a straight move, by axis.
struct MotionLimits {
  Vec3<double> feed_mm_s = Vec3<double>::Constant(100);
  Vec3<double> acceleration_mm_s2 = Vec3<double>::Constant(500);
  /// Largest change of an axis's feed between two moves that are blended
  /// (RepRapFirmware's M566 "jerk").
  Vec3<double> jerk_mm_s = Vec3<double>::Constant(10);
};

/// A straight move asked for.
struct PlannedMove {
  Segment segment{};     ///< Its profile is filled in by the queue.
  Vec3<double> along{};  ///< Unit vector of the move [mm], backlash steps left out.
  double feed_mm_s = 1;  ///< Asked for, already within the axes' limits.
  double acceleration_mm_s2 = 1;
  double most_in_mm_s = 0;  ///< At the junction with the move before.
};

/// A move along `delta_mm` at no more than `feed_mm_s` (infinite: as fast as the axes
/// go): no axis exceeds its own feed or acceleration.
PlannedMove MakeMove(const Vec3<double>& delta_mm,
                     double feed_mm_s,
                     const MotionLimits& limits);

/// Feed at which one move may go over into the next [mm/s]: no axis's feed jumps by
/// more than its jerk, v |u2 - u1| <= jerk for each, and neither exceeds what it was
/// asked.
double JunctionFeed_mm_s(const PlannedMove& before,
                         const PlannedMove& after,
                         const MotionLimits& limits);

/// Moves that wait, blended with look-ahead: each begins and ends as fast as its
/// junctions and the distance left for braking allow; the last one ends at rest.
class MoveQueue {
 public:
  explicit MoveQueue(const MotionLimits& limits) : limits_(limits) {}

  bool empty() const { return moves_.empty(); }
  std::size_t size() const { return moves_.size(); }
  void Add(PlannedMove move);
  /// Takes the first move, its profile complete. What follows begins at its final feed.
  Segment TakeFirst();
  /// Drops everything; the next move begins at rest.
  void Clear();

 private:
  MotionLimits limits_;
  std::deque<PlannedMove> moves_{};
  double feed_now_mm_s_ = 0;  ///< At the end of the move taken last.
};

}  // namespace caltwin

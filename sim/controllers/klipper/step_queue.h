#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "sim/controllers/klipper/clock.h"

namespace caltwin {
namespace klipper {

/// The clock nearest to `now` (within 2^31 ticks) whose lowest 32 bits are these.
Clock Extended(std::int64_t clock32, Clock now);

/// Steps that the host has ordered in one go:
///
///   step k (1 .. count) falls at  start + k interval + add k (k - 1) / 2   [ticks]
struct StepMove {
  Clock start = 0;
  std::int64_t interval = 0;
  std::int64_t count = 0;
  std::int64_t add = 0;
  int sense = 1;  ///< +1: the position counts up.

  Clock StepClock(std::int64_t step) const;
  Clock end() const { return StepClock(count); }
  /// How many steps have fallen, those due exactly at that clock included.
  std::int64_t StepsDone(Clock clock) const;
  /// Whether each step falls later than the one before.
  bool IsOrdered() const;
};

/// What one motor was told to do, and where that has it at any time not yet forgotten.
class StepQueue {
 public:
  /// Position at that clock [steps], 0 as configured.
  std::int64_t At(Clock clock) const;
  /// Whether steps are still to come.
  bool IsActive(Clock now) const {
    return !moves_.empty() && moves_.back().end() > now;
  }
  /// Moves that take a place in the chip's queue: the one that is performed, or is to
  /// be next, was taken out of it.
  std::size_t num_waiting() const { return moves_.empty() ? 0 : moves_.size() - 1; }

  enum class Fault { kNone, kTooClose, kTooFarInPast };
  /// Appends steps; the first falls an interval after the last one queued or after the
  /// reset clock, in 32 bits, which are extended around `now`. `sense`: +1, -1.
  Fault Append(std::int64_t interval,
               std::int64_t count,
               std::int64_t add,
               int sense,
               Clock now);
  /// The clock that the next interval counts from.
  void Reset(Clock clock) { last_ = clock; }
  /// Stands where it is at that clock; what is queued is dropped.
  void Stop(Clock clock);
  /// Appends the clocks in (from, to] at which the motor turns round.
  void AppendTurns(Clock from, Clock to, std::vector<Clock>* turns) const;
  /// Forgets moves that have ended before.
  void Forget(Clock before);

 private:
  std::deque<StepMove> moves_{};
  std::int64_t from_ = 0;  ///< Position before the first of them.
  Clock last_ = 0;         ///< Of the last step queued.
};

}  // namespace klipper
}  // namespace caltwin

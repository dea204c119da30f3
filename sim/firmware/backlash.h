#pragma once

#include <cstdint>

namespace caltwin {

/// Backlash compensation of one axis as RepRapFirmware 3.6.1 does it (M425; issue 1148
/// of its repository tells of the two counters): when the sense changes, all of the gap
/// is due at once, but a move takes on no more than its own length divided by the
/// distance factor (at least one step); what is left waits for the next moves.
class BacklashCompensation {
 public:
  /// Whole steps to be added to a move of `delta_steps`, which is not 0.
  /// @param gap_steps  the whole correction, from M425
  /// @param factor  a move of factor * gap_steps takes all of it
  std::int64_t Take(std::int64_t delta_steps, std::int64_t gap_steps, double factor);
  /// A move that was to apply `planned` steps was stopped and applied only `applied`:
  /// the rest is due again.
  void Stopped(std::int64_t planned, std::int64_t applied);
  /// The axis was homed, or its position set: nothing is applied, nothing is due.
  void Clear();
  /// What is in the motor's position is no longer known of (the defect before 3.6.1).
  void Forget();

  /// Steps in the motor's position that are none of the machine's.
  std::int64_t applied_steps() const { return applied_; }
  std::int64_t due_steps() const { return target_ - applied_; }
  /// Sense of the last move: +1, -1; 0 before the first, which counts as +.
  int sense() const { return sense_; }

 private:
  std::int64_t target_ = 0;
  std::int64_t applied_ = 0;
  int sense_ = 0;
};

}  // namespace caltwin

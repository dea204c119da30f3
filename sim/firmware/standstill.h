#pragma once

#include <cstdint>
#include <span>

namespace caltwin {

/// When a braked motor stood, from the onset of its brake.
struct Standstill {
  double at_s = 0;
  double sd_s = 0;        ///< From the counter's whole pulses.
  double rests_at_s = 0;  ///< When its counter had come to rest, to a tick.
  /// The motor was pushed on while it braked: its load came across a gap.
  bool is_knocked = false;
};

/// When a motor stood that was braked by a constant force, from its counter:
///
///   c(t) = c0 + v t - a t^2 / 2,  at = v / a
///
/// c0 and a by least squares from the counts until the motor stands, each known to
/// 1 / sqrt(12) of a pulse. Where the counts are no such path the load may have come
/// across a gap: then by the parabola of the counts after its last knock, with a speed
/// of its own. Else (an obstacle, rattling in a gap, too few counts): when it was
/// slower than a twentieth of its speed for good, or than a pulse a tick, to a tick; it
/// may creep on after that, until rests_at_s.
/// @param counts  at the onset of the brake and every tick after it, beyond standstill
/// @param speed_pulses_s  v, signed: as told to the drive before
Standstill StandstillOf(std::span<const std::int64_t> counts,
                        double tick_s,
                        double speed_pulses_s);

}  // namespace caltwin

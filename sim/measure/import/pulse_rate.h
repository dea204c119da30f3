#pragma once

#include <array>
#include <set>

#include "sim/measure/import/console_line.h"
#include "sim/measure/import/import.h"

namespace caltwin {

/// Whether a controller can send steps as fast as it is asked to:
///
///   pulses/s = steps/mm * feed / 60   [feed in mm/min]
///
/// grbl on an 8 bit board sends about 30 thousand; beyond that it loses steps, answers
/// garbled or stops. Feeds are what the text names in mm/min, or the largest allowed
/// ($110 to $112).
class PulseRate {
 public:
  void Take(const ConsoleLine& line);
  void Tell(Imported* imported) const;

 private:
  std::array<double, 3> steps_per_mm_{kUnknown, kUnknown, kUnknown};
  std::array<double, 3> most_mm_min_{kUnknown, kUnknown, kUnknown};
  std::set<double> feeds_mm_min_{};
  bool is_grbl_ = false;
  bool is_fast_board_ = false;  ///< grblHAL and other ports to 32 bit.
};

}  // namespace caltwin

#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "sim/machine/machine.h"

namespace caltwin::grbl {

/// @name Settings that the controller reads, by their number behind `$`
inline constexpr int kStatusMask = 10, kArcTolerance = 12, kReportInches = 13;
inline constexpr int kSoftLimits = 20, kHardLimits = 21, kHomingCycle = 22;
inline constexpr int kHomingMask = 23, kHomingFeed = 24, kHomingSeek = 25;
inline constexpr int kHomingPullOff = 27;
inline constexpr int kStepsPerMm = 100, kMaxRate = 110, kAcceleration = 120;
inline constexpr int kMaxTravel = 130;

/// What grbl keeps while it is switched off: `$` settings, work offsets, places of G28
/// and G30, start-up lines. Lengths in mm, rates in mm/min, as `$$` prints them.
class Memory {
 public:
  /// As somebody set it up who knew the drawing, with the steps/mm that `believed` has:
  /// homing is on, and soft limits with it.
  Memory(const Machine& machine, const Settings& believed);

  double Value(int number) const { return values_.at(number); }
  bool Is(int number) const { return Value(number) != 0; }
  /// Throws LineError where there is no such setting or it cannot be so.
  void Set(int number, double value);
  /// `$$`.
  std::vector<std::string> Lines() const;
  /// `$RST=$`, `$RST=#`.
  void RestoreSettings() { values_ = first_; }
  void ForgetPlaces();

  std::array<Vec3<double>, 6> workplaces_mm{};
  Vec3<double> place_28_mm{}, place_30_mm{};
  std::array<std::string, 2> startup_lines{};
  std::string build_text{};

 private:
  std::map<int, double> values_{};
  std::map<int, double> first_{};
};

}  // namespace caltwin::grbl

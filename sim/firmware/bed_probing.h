#pragma once

#include <array>
#include <optional>
#include <vector>

#include "sim/machine/screw_levelling.h"

namespace caltwin {

/// Where a firmware believes the screws under a bed to stand (M671).
struct Leadscrews {
  Pivots<double> at_mm{};
  double largest_mm = 10;  ///< M671 S: corrections above it are not made.
};

/// One touch of the bed by G30.
struct ProbedPoint {
  Eigen::Vector2d at_mm = Eigen::Vector2d::Zero();
  double stopped_mm = 0;  ///< Height of the nozzle over the bed, as counted there.
  /// Each screw beyond what that height alone has it told, whole steps, by the steps/mm
  /// that the machine began with.
  Vec3<double> raised_mm = Vec3<double>::Zero();
  double steps_per_mm = 0;  ///< Of z, in force,
  double backlash_mm = 0;   ///< and its backlash compensation.
  double feed_mm_s = 0;
  double at_s = 0;  ///< Machine time.
  int homing = 0;   ///< G28s of z before it.
};

/// What a firmware keeps for G30, M584 and M671.
struct BedProbing {
  std::optional<Leadscrews> leadscrews{};  ///< M671 now; none: the bed stands on none.
  std::vector<BedTouch> points{};          ///< Of G30 P, until S uses them.
  std::vector<ProbedPoint> probed{};
  int homings = 0;
  /// M584 Z0 U1 V2: each of z's motors is an axis of its own, Z U V, until joined.
  bool is_split = false;
  Vec3<double> split_mm = Vec3<double>::Zero();      ///< Machine coordinates of Z.
  std::array<bool, 3> are_placed{true, true, true};  ///< By G92.
};

}  // namespace caltwin

#pragma once

#include <functional>
#include <optional>
#include <string>

#include "sim/machine/axis.h"

namespace caltwin {

/// How the distance along one move grows with time: up at constant acceleration, along
/// at constant feed, down again; each part may be missing (a triangle, a junction).
struct Profile {
  double length_mm = 0;
  double feed_in_mm_s = 0;   ///< At the start, from look-ahead; 0: from standstill.
  double feed_top_mm_s = 1;  ///< Reached, not merely asked for.
  double feed_out_mm_s = 0;
  double acceleration_mm_s2 = 1;

  double Duration_s() const;
  /// Distance gone at time t, clamped to 0 .. length_mm.
  double Distance_mm(double t_s) const;
  /// Its inverse.
  double Time_s(double distance_mm) const;
  double Feed_mm_s(double t_s) const;
};

/// Steps, travels or speeds of a machine's motors, in its own order: x y z; a b z of
/// belts; the three towers of a delta; x y z1 z2 z3. Held without allocation.
inline constexpr int kMostMotors = 8;
using Motors =
    Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMostMotors, 1>;

/// One move of the motors, in absolute motor steps (0: the carriage at its home end
/// when the plant was switched on), backlash steps included, fractions allowed.
struct Segment {
  Motors from_steps = Motors::Zero(3);
  Motors to_steps = Motors::Zero(3);
  Profile profile{};
  /// Where the motors stand when so much of the profile's length is gone [mm], for
  /// moves that are no straight line to them: a delta's. Empty: a straight line.
  std::function<Motors(double gone_mm)> curve{};

  /// The motors at time t, gone along as the profile says.
  Motors Steps(double t_s) const;
};

/// What ends a move before its end.
struct Watch {
  enum class Kind {
    kNothing,
    kProbeTriggered,
    kProbeReleased,
    kSwitchClosed,
    kSwitchOpened
  };
  Kind kind = Kind::kNothing;
  Axis axis = Axis::kX;  ///< Whose switch.
};

/// How a move ended.
struct Outcome {
  bool stopped = false;  ///< By what was watched for, before the end.
  double time_s = 0;  ///< From its start: of the stop, latency included, or of its end.
  /// Where the motors stand, of which each stopped at a switch of its own. None: where
  /// the move has them at `time_s`.
  std::optional<Motors> stand_steps{};
  std::optional<std::string> alarm{};  ///< The stylus was bent beyond its overtravel.
};

/// The mechanism that a controller drives, as little of it as it can feel: motors along
/// a path in time out, switches and probe in. Gantry and CoreXY have one (physics
/// and fast) in sim/twin, a delta and a bed on screws theirs in sim/kinds; a test may
/// write another.
class Plant {
 public:
  virtual ~Plant() = default;
  /// Performs a move, or as much of it as comes before what is watched for. A stop is
  /// abrupt, as a controller's is: the motors stand where the stop found them.
  virtual Outcome Run(const Segment& segment, const Watch& watch) = 0;
  /// After a stop: the motors settle on these whole steps (at most one away).
  virtual void Settle(const Motors& steps) = 0;
  virtual void Dwell(double s) = 0;
  virtual bool ProbeTriggered() = 0;
  virtual bool SwitchClosed(Axis axis) = 0;
};

}  // namespace caltwin

#pragma once

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
  double Feed_mm_s(double t_s) const;
};

/// One straight move of the motors, in absolute motor steps (0: the carriage at its
/// home end when the plant was switched on), backlash steps included, fractions
/// allowed.
struct Segment {
  Vec3<double> from_steps = Vec3<double>::Zero();
  Vec3<double> to_steps = Vec3<double>::Zero();
  Profile profile{};

  /// The motors at time t: a straight line, gone along as the profile says.
  Vec3<double> Steps(double t_s) const;
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
  std::optional<std::string> alarm{};  ///< The stylus was bent beyond its overtravel.
};

/// The mechanism that firmware drives, as little of it as a controller can feel: motors
/// out, switches and probe in. Two of them exist (physics, fast), both in sim/twin; a
/// test may write a third.
class Plant {
 public:
  virtual ~Plant() = default;
  /// Performs a move, or as much of it as comes before what is watched for. A stop is
  /// abrupt, as a controller's is: the motors stand where the stop found them.
  virtual Outcome Run(const Segment& segment, const Watch& watch) = 0;
  /// After a stop: the motors settle on these whole steps (at most one away).
  virtual void Settle(const Vec3<double>& steps) = 0;
  virtual void Dwell(double s) = 0;
  virtual bool ProbeTriggered() = 0;
  virtual bool SwitchClosed(Axis axis) = 0;
};

}  // namespace caltwin

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/machine/artefact.h"
#include "sim/machine/axis.h"

namespace caltwin {

/// One surface of an artefact that the probe can reach, where the papers say it lies.
struct Face {
  std::string artefact{};  ///< Its id; "bed" for the table.
  std::string feature{};   ///< As rows name it: "block.left", "bed.top".
  Vec3<double> at_mm = Vec3<double>::Zero();  ///< Nominal touched point.
  Vec3<double> n = Vec3<double>::UnitX();     ///< Outward normal, into the air.
  bool internal = false;  ///< A wall of a hole, approached from its middle.
  /// Free way in front of an internal face up to the middle of the hole [mm].
  double room_mm = 0;
  /// Reached from below, by the disc stylus, coming in from beside the lip.
  bool from_below = false;

  /// Sense in which a machine moves along `axis` to touch it: +1, -1, or 0.
  int ApproachSense(Axis axis) const;
};

/// All faces of an artefact: left (-x), right (+x), front (-y), back (+y), top, and
/// bottom of a ledge; a hole's walls are named after the side on which they lie. Walls
/// are touched halfway up, at most 12.7 mm below the top.
std::vector<Face> FacesOf(const Artefact& artefact);

/// The two faces across `axis` whose distance is a certified size, the one nearer the
/// axis's minimum first. Empty where there are none: one for z but of a ledge, and
/// artefacts that are turned out of the axes.
std::vector<Face> FacesAcross(const Artefact& artefact, Axis axis);

/// The face that looks up.
std::optional<Face> TopOf(const Artefact& artefact);

/// The table at a place, z = 0 by the drawing.
Face TableAt(double x_mm, double y_mm);

/// Height of the artefact's top above the table.
double Top_mm(const Artefact& artefact);

}  // namespace caltwin

#pragma once

#include <string>
#include <vector>

#include "sim/measure/import/import.h"
#include "sim/measure/import/klipper_geometry.h"

namespace caltwin {

/// One touch of a saved delta calibration.
struct KlipperTouch {
  Vec3<double> counts = Vec3<double>::Zero();  ///< Microsteps down from the endstops.
  Vec3<double> motors_mm = Vec3<double>::Zero();  ///< The same as travel.
  double height_mm = 0;    ///< Of the nozzle above the bed at the trigger.
  bool is_manual = false;  ///< Measured with paper, not by the probe.
  Place place{};
};

/// A distance on a printed object, measured with a calliper: between the places where
/// the carriages stood.
struct KlipperDistance {
  double length_mm = 0;
  Vec3<double> from_mm = Vec3<double>::Zero();
  Vec3<double> to_mm = Vec3<double>::Zero();
};

/// All that a `[delta_calibrate]` block holds, and the geometry saved with it.
struct KlipperCalibration {
  KlipperGeometry geometry{};
  std::vector<KlipperTouch> touches{};
  std::vector<KlipperDistance> distances{};
  /// Step of the counts over the step of the file: microsteps were changed since.
  double step_factor = 1;
};

/// The motor step that puts the touch nearest to the middle, where all carriages stand
/// alike, at its height, if the saved endstops are those of the touches; kUnknown where
/// there is none.
double LikelyStep_mm(const KlipperGeometry& geometry,
                     const std::vector<KlipperTouch>& touches);

/// Reads the block from a printer.cfg. Throws InputError, file:line:column, with every
/// fault: no block, numbers that are none, no motor step (with the step that the
/// touches suggest), a geometry that does not reach its own touches. At most 999
/// touches and distances, as in Klipper.
KlipperCalibration ReadKlipperCalibration(const std::string& text,
                                          const std::string& name,
                                          const ImportOptions& options);

/// The same as rows: `touch` of bed.top at the place where the saved geometry puts the
/// nozzle, value = its height by the saved geometry - the height it had. `motor_` is
/// the carriages' travel to the nominal point (x, y, 0); the raw counts and the height
/// are kept as columns count_a, count_b, count_c, height_mm.
Imported ReadKlipperDelta(const std::string& text,
                          const std::string& name,
                          const ImportOptions& options);

/// The meshes of a printer.cfg (ReadKlipperMesh); of a delta's also what its saved
/// calibration says of itself, where it can be read.
Imported ReadMeshesOfPrinter(const std::string& text,
                             const std::string& name,
                             const ImportOptions& options);

}  // namespace caltwin

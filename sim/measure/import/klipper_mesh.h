#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/measure/import/import.h"
#include "sim/measure/import/klipper_geometry.h"

namespace caltwin {

/// One probed place of a bed.
struct MeshPoint {
  double x_mm = 0;
  double y_mm = 0;
  double z_mm = 0;  ///< Nozzle height that the firmware believed as it touched.
  Place place{};
};

/// A mesh as it was probed.
struct KlipperMesh {
  std::string name{};  ///< Of the profile: "default".
  int x_count = 0;
  int y_count = 0;
  bool is_round = false;            ///< Corners beyond its radius were copies.
  std::size_t num_copies = 0;       ///< Left out.
  double radius_mm = kUnknown;      ///< Of a round one.
  std::vector<MeshPoint> points{};  ///< Row by row, y upwards.
};

/// All that a printer.cfg says of its bed.
struct KlipperBed {
  std::vector<KlipperMesh> meshes{};
  /// Of a delta, as saved in the same file; nullopt of other machines.
  std::optional<KlipperGeometry> geometry{};
  std::vector<std::string> warnings{};
};

/// Reads every `[bed_mesh NAME]` with points. A mesh is round where every point beyond
/// the circle through the middles of its sides equals the outermost probed point of
/// its row: Klipper fills the square that way. Throws InputError with every fault; at
/// most 10 000 points a mesh.
KlipperBed ReadKlipperBed(const std::string& text, const std::string& name);

/// The same as rows: `touch` of bed.top, a campaign a mesh, value = believed height of
/// the bed. Of a delta `motor_` is the travel to (x, y, 0) by the saved geometry.
Imported ReadKlipperMesh(const std::string& text,
                         const std::string& name,
                         const ImportOptions& options);

}  // namespace caltwin

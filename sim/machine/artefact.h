#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "sim/base/yaml.h"
#include "sim/machine/axis.h"

namespace caltwin {

/// What stands on the table to be touched.
enum class ArtefactType { kBlock123, kWeb, kRing, kPocket, kLedge, kPlate };

/// An artefact and where it lies. The same struct holds the drawing (certificate and
/// nominal place: what the engine may know) and the built one (the twin's truth).
///
/// Shapes, in the artefact's own axes, origin at the centre of its base, z up:
/// - block123: a box, `size_mm` = what lies along x, y, z, a permutation of 25.4, 50.8
///   and 76.2. `side: x` in a file: 76.2 along x, 50.8 along y (side z: 50.8 along x,
///   25.4 along y, 76.2 up).
/// - web: a thin wall, `size_mm` = its thickness along `side`, 60 across, 30 high.
/// - ring: a bore of `size_mm[0]` diameter through a ring 20 high; touched from inside.
/// - pocket: a square hole of `size_mm[0]` width, 20 deep, touched from inside.
/// - ledge: a lip of thickness `size_mm[2]`, 40 x 40, its underside 30 above the base:
///   touched from above, and from below with the disc stylus.
/// - plate: a flat surface, `size_mm` = extent along x, y and height.
struct Artefact {
  std::string id;
  ArtefactType type = ArtefactType::kBlock123;
  Vec3<double> at_mm = Vec3<double>::Zero();  ///< Centre of the base, machine axes.
  Vec3<double> size_mm = Vec3<double>(76.2, 50.8, 25.4);
  Axis side = Axis::kX;
  double turn_deg = 0;  ///< About its vertical, counter-clockwise from above.
  double u_um = 0;      ///< Standard uncertainty of each certified size.
  /// Of a 1-2-3 block, true minus certified: its least, middle and largest size. What
  /// nobody knows; the twin's alone.
  std::array<double, 3> off_mm{};
};

std::string ToString(ArtefactType type);

/// Sizes of the 1-2-3 block [mm].
inline constexpr std::array<double, 3> kBlockSizes_mm = {25.4, 50.8, 76.2};

/// The block turned so that `length_mm` lies along `axis`, the other two sizes kept in
/// descending order along the remaining axes x, y, z. Throws logic_error for a length
/// that is not one of the block's.
Vec3<double> BlockLying(Axis axis, double length_mm);

std::vector<std::string> IdsOf(const std::vector<Artefact>& artefacts);

/// Reads `artefacts: {id: {type: , at_mm: [x, y, z], ...}}`. Keys: type, at_mm, side
/// (block123, web), thickness_mm (web, ledge), diameter_mm (ring), width_mm (pocket),
/// size_mm (plate), turn_deg, u_um.
std::vector<Artefact> ReadArtefacts(YamlMap map);

}  // namespace caltwin

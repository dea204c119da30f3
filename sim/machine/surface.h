#pragma once

#include <vector>

#include "sim/machine/artefact.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// A box of stuff, axes-parallel but for a turn about its vertical; or, with a bore, an
/// upright tube (half_mm.x the outer, bore_radius_mm the inner radius).
struct Solid {
  Vec3<double> center_mm = Vec3<double>::Zero();
  Vec3<double> half_mm = Vec3<double>::Ones();
  double turn_rad = 0;
  double bore_radius_mm = 0;  ///< 0: a box.
};

/// What the artefact is made of, in machine axes, upright on an untilted table. Both
/// fidelities build from this list: geoms for MuJoCo, distances for the closed form.
std::vector<Solid> SolidsOf(const Artefact& artefact);
/// The table: a slab under the whole travel whose top is z = 0.
Solid TableOf(const Machine& machine);

/// Distance from a point to the nearest surface, negative inside, and the outward unit
/// normal there. Exact outside; inside a single solid too (the depth to the nearest
/// face).
struct SurfaceDistance {
  double distance_mm = 1e9;
  Vec3<double> normal = Vec3<double>::UnitZ();
  std::size_t solid = 0;  ///< Which one, where it was sought among several.
};

SurfaceDistance DistanceTo(const Solid& solid, const Vec3<double>& p_mm);
SurfaceDistance NearestOf(const std::vector<Solid>& solids, const Vec3<double>& p_mm);

}  // namespace caltwin

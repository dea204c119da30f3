#pragma once

#include <string>

#include "calibration/kinds/delta/joint.h"
#include "sim/machine/kinds/delta/mesh.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {

/// What settings leave between nozzle and bed on the machine that a fit found, as a
/// firmware's mesh takes it away: no touch more than those of the fit. Three-rod
/// settings cannot hold unlike rods and leaning towers; a mesh can, on the bed. Nodes
/// beyond the disc, where rods hardly reach, are as on its rim.
DeltaMesh ForetoldMesh(const DeltaJointFit& fit,
                       const DeltaModel<double>& settings,
                       double radius_mm,
                       int nodes);

/// @name A mesh as a firmware takes it
/// Marlin: `M421 I J Z` for every node, then `M420 S1`.
std::string MeshAsMarlin(const DeltaMesh& mesh);
/// Klipper: `[bed_mesh default]` of printer.cfg.
std::string MeshAsKlipper(const DeltaMesh& mesh);

}  // namespace caltwin

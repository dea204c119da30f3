#pragma once

#include "sim/base/yaml.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// What a delta's drawing has beside its axes, and what its firmware starts with.
struct DeltaDrawing {
  DeltaModel<double> model = SymmetricDelta(300, 130, 250);  ///< As drawn.
  double rod_spacing_mm = 40;
  double effector_radius_mm = 30;
  bool states_effector = false;  ///< The file says how large the effector is.
  double joint_height_mm = 20;
  double effector_mass_kg = 0.35;  ///< All that hangs on the rods.
  double print_radius_mm = 100;    ///< Of the bed's part that is probed and printed on.
  DeltaModel<double> settings = model;  ///< As drawn where the file says nothing.

  /// Built exactly as drawn.
  DeltaBuild<double> Build() const;
};

/// Reads a number for all towers, or a map of them, over `values` in place.
void ReadByTower(YamlMap* map,
                 const std::string& key,
                 Bounds bounds,
                 std::array<double, 3>* values);

/// Reads the delta's own keys of a machine file: `towers`, `delta_radius_mm`,
/// `arm_length_mm`, `endstop_mm` (a number, or one a tower), `rod_spacing_mm`,
/// `effector_radius_mm`, `joint_height_mm`, `print_radius_mm`.
DeltaDrawing ReadDeltaDrawing(YamlMap* map);

/// Reads what a delta's firmware believes over `settings` in place: `delta_radius_mm`,
/// `arm_length_mm`, `endstop_mm`, `tower_angle_deg` (against the drawing), each a
/// number or one a tower.
void ReadDeltaSettings(YamlMap* map,
                       const DeltaModel<double>& drawn,
                       DeltaModel<double>* settings);

/// The drawing of a delta, which the machine must be.
inline const DeltaDrawing& DeltaOf(const Machine& machine) {
  return *machine.Own<DeltaDrawing>();
}
inline DeltaDrawing& DeltaOf(Machine& machine) {
  return *machine.Own<DeltaDrawing>();
}

/// What hangs on a tower's drive: the carriage and its share of the effector, which is
/// by how much the nozzle rises as that carriage does (virtual work; rods are taken to
/// weigh nothing).
///
///   load = (carriage + effector dz / dcarriage) g   [N]
///
/// More than the rail's friction, and the weight, not the last direction, decides on
/// which side of its gap the carriage rests: it hangs.
double TowerLoad_n(const AxisDrawing& tower,
                   const DeltaDrawing& delta,
                   double nozzle_per_carriage);

}  // namespace caltwin

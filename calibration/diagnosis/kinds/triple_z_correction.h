#pragma once

#include <string>

#include "calibration/diagnosis/controller.h"
#include "calibration/diagnosis/diagnosis.h"

namespace caltwin {

/// What a printer whose bed stands on three screws is told, from what a diagnosis found
/// of it: where the screw of each driver stands, and its steps.
///
///   RRF      M671 X Y, in the order of M584's Z drivers; M92 Z; M425 Z
///   Marlin   M422 W1 .. W3 (Z_STEPPER_ALIGN_KNOWN_STEPPER_POSITIONS); M92 Z; M425
///   Klipper  [z_tilt] z_positions, in the order of stepper_z, _z1, _z2;
///            rotation_distance of each of these, so each screw's pitch too
///
/// Motors that are exchanged stay where they are plugged in: the places are written in
/// the order of the drivers, which levels as well. Of a bed that guides hold level they
/// are where the screws seem to stand: over such a place the bed follows that screw
/// alone, so that levelling by them is exact (WeightsHeldBack). By how much each screw
/// is to be raised is a comment: the plane through the touches as the values found have
/// them, on a lattice over the travel, taken away at these places, the mean of the
/// three as it is. What no setting carries is a comment. Throws as
/// RequireScrewLevelling does.
std::string TripleZCorrectionText(ControllerKind controller,
                                  const Diagnosis& diagnosis,
                                  const Observed& observed);

/// Throws InputError for LinuxCNC, which levels no bed by its screws.
void RequireScrewLevelling(ControllerKind controller);

}  // namespace caltwin

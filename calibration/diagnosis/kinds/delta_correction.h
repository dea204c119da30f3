#pragma once

#include <string>

#include "calibration/diagnosis/correction.h"

namespace caltwin {

/// The geometry with which a delta's firmware prints best, from what a diagnosis found
/// of it: the exact six-rod chain with baseline and findings built in, held against
/// three rods by BestDeltaSettings (heights first; one radius, a rod length a tower).
///
///   Marlin   M92, M665 L R H X Y Z A B C, M666
///   RRF      M92, M665 L R H X Y Z, M666
///   Klipper  [printer] delta_radius, [stepper_a] position_endstop, arm_length, angle,
///            rotation_distance
///
/// A belt's pitch (steps/mm) is written where two standard deviations, or a finding,
/// tell it; the geometry where at least one of its numbers is told so from what the
/// firmware has. The numbers stand together: rods, radius and belts trade, so that one
/// alone is known worse than what they do together. Height 0 is where touches trigger:
/// a probe's own offset is M851's. Carriages with play are taken in the middle of their
/// gaps, as far above as below where a touch finds them. Bends of the bed are left to a
/// mesh and are no part of it. What no number carries is a comment. The text says what
/// is left, as far as the values found are true. Throws as RequireDeltaGeometry does.
std::string DeltaCorrectionText(ControllerKind controller,
                                const Diagnosis& diagnosis,
                                const Observed& observed);

/// Throws InputError for LinuxCNC, whose delta kinematics have one rod length and one
/// radius, and neither endstops nor angles.
void RequireDeltaGeometry(ControllerKind controller);

}  // namespace caltwin

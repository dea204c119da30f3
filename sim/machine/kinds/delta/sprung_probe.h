#pragma once

#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/kinds/delta/play.h"

namespace caltwin {

/// A sprung probe as the twin has one: a tip that hangs on its stop until the bed lifts
/// it, from then on pressed down by spring and preload.
inline constexpr double kProbePreload_n = 0.5;
inline constexpr double kProbeStiffness_n_per_mm = 0.05;
inline constexpr double kProbeMass_kg = 0.003;

/// WithPlayTaken at the trigger of a sprung probe, all motors on their way straight
/// down. From the contact on the probe carries a part of what hangs on each tower:
///
///   load_i = (carriage + effector r_i) g - preload r_i,   r_i = dz / dcarriage_i
///
/// A carriage that hung and now weighs less than its rail holds stands still, while its
/// drive goes on down, until its gap is taken up from above:
///
///   endstop_i += gap_i / 2   (and not -= gap_i / 2)
///
/// Meanwhile the nozzle comes down by what the others make of it, 1 - sum of r_i.
/// Throws InputError where the trigger may come before the gap is crossed, three times
/// the way included on which a carriage stops that came down at 5 mm/s: there its speed
/// decides. Neglected: what the spring gains on the pre-travel (0.05 N per mm).
/// nullopt: the chain does not close.
std::optional<DeltaBuild<double>> WithPlayTakenByProbe(const DeltaBuild<double>& build,
                                                       const Machine& machine,
                                                       const CarriageGaps_mm& gaps_mm,
                                                       const Vec3<double>& motors_mm,
                                                       double pretravel_mm);

}  // namespace caltwin

#pragma once

#include <string>

#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/kinds/delta/touch.h"

namespace caltwin {

/// What a firmware's geometry has numbers for.
struct DeltaSettingsShape {
  bool has_radius_per_tower = true;  ///< Else one radius for all.
  bool has_arm_per_tower = true;     ///< Else one arm length for all.
};

/// The settings with which a machine prints best: least squares of where the nozzle
/// goes against where it is sent, all over a disc on the bed and 40 mm above it;
/// heights on the bed weigh 200 times as much as places, and the scale of all places
/// together as much as they do: else flatness would be bought with size. Heights above
/// the bed weigh as places, for touches of the bed tell them less. `from`: where to
/// start, and what the firmware has no number for.
DeltaModel<double> BestDeltaSettings(const DeltaBuild<double>& build,
                                     const DeltaBed<double>& bed,
                                     const DeltaModel<double>& from,
                                     double radius_mm,
                                     const DeltaSettingsShape& shape = {});

/// @name Settings as a firmware takes them
/// Angles against `drawn`: what the firmware adds its corrections to (RepRapFirmware
/// and Marlin: towers X, Y, Z at 210, 330, 90 deg). RepRapFirmware: `M665 L.. R.. H..
/// X.. Y.. Z..` (angle corrections in deg of towers X, Y, Z at 210, 330, 90 deg; a rod
/// for each as L a:b:c where they differ) and `M666 X.. Y.. Z..` (endstop corrections,
/// +: that tower's endstop is higher; their sum is 0).
std::string AsRrf(const DeltaModel<double>& settings, const DeltaModel<double>& drawn);
/// Marlin: `M665 L R H X Y Z A B C` (angle trims X Y Z, rod trims A B C) and `M666 X Y
/// Z` (how far each carriage backs off from its endstop, none above 0: to the lowest of
/// them, and H is its height; Marlin homes to H so). It has one radius for all towers.
std::string AsMarlin(const DeltaModel<double>& settings,
                     const DeltaModel<double>& drawn);
/// Klipper's printer.cfg: `[printer] delta_radius`, `[stepper_a] position_endstop,
/// arm_length, angle` and so on.
std::string AsKlipper(const DeltaModel<double>& settings);

}  // namespace caltwin

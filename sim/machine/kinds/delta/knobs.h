#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/base/units.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/kinds/delta/touch.h"

namespace caltwin {

/// One way in which a delta may differ from its drawing, as an unknown of an estimate.
/// Values are reported in `unit`; inside they are mm, rad and fractions.
struct DeltaKnob {
  std::string_view name{};  ///< As in files and JSON: `cause.axis`.
  std::string_view unit{};
  double per_unit = 1;  ///< Inside value of one unit.
  double prior_sd = 0;  ///< How far machines stray from their drawings [unit].
};

inline constexpr double kDegree = RadFromDeg(1.0);

/// All of them, in the order of TurnKnob. Signs as CONTRACT has them: built less drawn;
/// angles counter-clockwise; leans outward and counter-clockwise; belts that move too
/// far positive.
///
/// - The rods of a prior of 0.05 mm were measured by calliper as one length
///   (`arm_length`); each may stray from it (`rod_mismatch`).
/// - Tower c is the reference of angle and radius: together with the common radius and
///   the machine's own turn the third would say nothing new.
inline constexpr std::array kDeltaKnobs = {
    DeltaKnob{"endstop.a", "mm", 1, 5},
    DeltaKnob{"endstop.b", "mm", 1, 5},
    DeltaKnob{"endstop.c", "mm", 1, 5},
    DeltaKnob{"delta_radius", "mm", 1, 5},
    DeltaKnob{"tower_angle.a", "deg", kDegree, 2},
    DeltaKnob{"tower_angle.b", "deg", kDegree, 2},
    DeltaKnob{"arm_length", "mm", 1, 0.05},
    DeltaKnob{"rod_mismatch.a1", "mm", 1, 0.1},
    DeltaKnob{"rod_mismatch.a2", "mm", 1, 0.1},
    DeltaKnob{"rod_mismatch.b1", "mm", 1, 0.1},
    DeltaKnob{"rod_mismatch.b2", "mm", 1, 0.1},
    DeltaKnob{"rod_mismatch.c1", "mm", 1, 0.1},
    DeltaKnob{"rod_mismatch.c2", "mm", 1, 0.1},
    DeltaKnob{"tower_radius.a", "mm", 1, 0.3},
    DeltaKnob{"tower_radius.b", "mm", 1, 0.3},
    DeltaKnob{"tower_lean.a.radial_mrad", "mrad", 1e-3, 2},
    DeltaKnob{"tower_lean.b.radial_mrad", "mrad", 1e-3, 2},
    DeltaKnob{"tower_lean.c.radial_mrad", "mrad", 1e-3, 2},
    DeltaKnob{"tower_lean.a.tangential_mrad", "mrad", 1e-3, 2},
    DeltaKnob{"tower_lean.b.tangential_mrad", "mrad", 1e-3, 2},
    DeltaKnob{"tower_lean.c.tangential_mrad", "mrad", 1e-3, 2},
    DeltaKnob{"tower_twist.a", "deg", kDegree, 0.5},
    DeltaKnob{"tower_twist.b", "deg", kDegree, 0.5},
    DeltaKnob{"tower_twist.c", "deg", kDegree, 0.5},
    DeltaKnob{"belt_pitch.a", "ppm", 1e-6, 300},
    DeltaKnob{"belt_pitch.b", "ppm", 1e-6, 300},
    DeltaKnob{"belt_pitch.c", "ppm", 1e-6, 300},
    DeltaKnob{"bed_tilt.slope_x_mrad", "mrad", 1e-3, 10},
    DeltaKnob{"bed_tilt.slope_y_mrad", "mrad", 1e-3, 10},
    DeltaKnob{"bed_bowl", "mm", 1, 0.2},
    DeltaKnob{"bed_cylinder.x", "mm", 1, 0.2},
    DeltaKnob{"bed_twist", "mm", 1, 0.2}};
inline constexpr int kNumDeltaKnobs = static_cast<int>(kDeltaKnobs.size());

/// @name First of each kind, one after another by tower or rod
inline constexpr int kEndstopKnob = 0;
inline constexpr int kRadiusKnob = 3;
inline constexpr int kAngleKnob = 4;  ///< Of towers a and b.
inline constexpr int kArmKnob = 6;
inline constexpr int kRodKnob = 7;
inline constexpr int kTowerRadiusKnob = 13;  ///< Of towers a and b.
inline constexpr int kLeanRadialKnob = 15;
inline constexpr int kLeanTangentialKnob = 18;
inline constexpr int kTwistKnob = 21;
inline constexpr int kBeltKnob = 24;
inline constexpr int kBedKnob = 27;

/// Index of the knob of that name; nullopt for anything else.
std::optional<int> DeltaKnobNamed(std::string_view name);
/// Indices of these names; throws InputError naming the closest knob.
std::vector<int> DeltaKnobsNamed(std::span<const std::string> names);

/// Whether the knob is a tower's angle.
constexpr bool IsAngleKnob(int knob) {
  return knob >= kAngleKnob && knob < kArmKnob;
}

/// How far machines stray from their drawings in this knob (inside value). A tower
/// stands round by its prior; of three-rod formulas that is more where the drawing
/// states the effector (`twist_per_angle`).
double PriorSdOf(int knob, const DeltaBuild<double>& drawn);

/// @name Usual choices
/// What three-rod firmwares set, with the bed's tilt beside it: endstops, radius,
/// angles, slopes.
std::vector<int> FirmwareKnobs();
/// Everything about the machine itself, the bed a plane: 27 unknowns and two slopes.
std::vector<int> MachineKnobs();

/// The same of the bed's knobs, counted from kBedKnob.
template <typename Bed, typename With>
void AtBedKnob(int knob, Bed& bed, const With& with) {
  const std::array numbers = {
      &bed.slope_x, &bed.slope_y, &bed.bowl_mm, &bed.cylinder_x_mm, &bed.twist_mm};
  with(*numbers[static_cast<std::size_t>(knob)]);
}

/// Calls `with` on each number of a machine and its bed that the knob moves; the last
/// of a shared one is tower c's. `Build` and `Bed` may be const.
template <typename Build, typename Bed, typename With>
void AtKnob(int knob, Build& build, Bed& bed, const With& with) {
  auto& model = build.model;
  // The i-th number of a list that begins at one knob and ends before the next.
  const auto from = [knob](int first) {
    return static_cast<std::size_t>(knob - first);
  };
  if (knob < kRadiusKnob) {
    with(model.endstop_mm[from(kEndstopKnob)]);
  } else if (knob < kAngleKnob) {
    std::ranges::for_each(model.radius_mm, with);
  } else if (knob < kArmKnob) {
    with(model.angle_rad[from(kAngleKnob)]);
  } else if (knob < kRodKnob) {
    std::ranges::for_each(model.arm_mm, with);
  } else if (knob < kTowerRadiusKnob) {
    with(build.rod_error_mm[from(kRodKnob)]);
  } else if (knob < kLeanRadialKnob) {
    with(model.radius_mm[from(kTowerRadiusKnob)]);
  } else if (knob < kLeanTangentialKnob) {
    with(build.lean_radial_rad[from(kLeanRadialKnob)]);
  } else if (knob < kTwistKnob) {
    with(build.lean_tangential_rad[from(kLeanTangentialKnob)]);
  } else if (knob < kBeltKnob) {
    with(build.twist_rad[from(kTwistKnob)]);
  } else if (knob < kBedKnob) {
    with(build.belt_scale[from(kBeltKnob)]);
  } else {
    AtBedKnob(knob - kBedKnob, bed, with);
  }
}

/// Turns one knob of a machine by `by` (inside value, added to what it has). The angle
/// of a tower is the firmware's, and its carriage is twisted with it by
/// `twist_per_angle`; the knob of the twist is what it is twisted beside that.
template <typename T>
void TurnKnob(int knob, const T& by, DeltaBuild<T>* build, DeltaBed<T>* bed) {
  AtKnob(knob, *build, *bed, [&by](T& value) { value += by; });
  if (IsAngleKnob(knob)) {
    build->twist_rad[static_cast<std::size_t>(knob - kAngleKnob)] +=
        build->twist_per_angle * by;
  }
}

/// How far a knob of a machine on its bed is turned against its drawing [the knob's
/// unit]; a tower's radius and angle against tower c's. Undoes TurnKnob.
double KnobValue(int knob,
                 const DeltaBuild<double>& build,
                 const DeltaBed<double>& bed,
                 const DeltaBuild<double>& drawn);

}  // namespace caltwin

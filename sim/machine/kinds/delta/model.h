#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

#include <Eigen/Core>

#include "sim/machine/axis.h"

namespace caltwin {

/// The towers of a linear delta, as Klipper orders them: a front left (210 deg), b
/// front right (330 deg), c at the back (90 deg).
inline constexpr int kNumTowers = 3;
inline constexpr int kNumRods = 6;
/// "a", "b", "c".
std::string TowerName(int tower);
/// The tower of that name; nullopt for anything else.
std::optional<int> TowerNamed(std::string_view name);
/// "a1" (the clockwise one of tower a seen from above), "a2", "b1" ...; rod = 2 tower +
/// (0 or 1).
std::string RodName(int rod);
std::optional<int> RodNamed(std::string_view name);

/// What three-rod formulas know of a delta, the two rods of a tower being one. All that
/// public firmwares model is in here.
///
///   carriage_i = z + sqrt(arm_i^2 - |p_i - (x, y)|^2),  p_i = radius_i (cos, sin)
///   angle_i motor_i = endstop_i + sqrt(arm_i^2 - radius_i^2) - carriage_i   (down from
///   its endstop)
///
/// Angles counter-clockwise from +x.
template <typename T>
struct DeltaModel {
  std::array<T, 3> endstop_mm{};  ///< Nozzle height with that carriage at its endstop.
  std::array<T, 3> radius_mm{};   ///< From tower joint to effector joint, horizontally.
  std::array<T, 3> angle_rad{};
  std::array<T, 3> arm_mm{};
};

/// A delta as it is built, six rods and an effector that may tilt.
template <typename T>
struct DeltaBuild {
  DeltaModel<T> model{};  ///< `arm_mm`: of a tower's two rods the mean as drawn.
  std::array<T, 6> rod_error_mm{};     ///< Of each rod against its tower's `arm_mm`.
  std::array<T, 3> lean_radial_rad{};  ///< +: the top goes outward; pivot at z = 0.
  std::array<T, 3> lean_tangential_rad{};  ///< +: the top goes counter-clockwise.
  std::array<T, 3>
      twist_rad{};  ///< Carriage about its own vertical, counter-clockwise.
  std::array<T, 3> belt_scale{};  ///< Moved over commanded, less 1; 0 as drawn.
  T tool_tilt_x_rad{};            ///< Of the tool on its effector, right-handed.
  T tool_tilt_y_rad{};
  /// @name As drawn; they change nothing while all errors are nought.
  double rod_spacing_mm = 40;
  double effector_radius_mm = 30;
  /// Twist of a carriage whose tower stands round, over the firmware's angle of it
  /// (`TwistPerAngle`). 0: no drawing states the effector, whose joints then turn too.
  double twist_per_angle = 0;
  double joint_height_mm = 20;  ///< Effector joints above the nozzle.
};

/// Where the effector is: its nozzle, and its tilt as Cayley parameters g (a rotation
/// by 2 atan |g| about g).
template <typename T>
struct DeltaPose {
  Vec3<T> nozzle_mm = Vec3<T>::Zero();
  Vec3<T> cayley = Vec3<T>::Zero();
};

/// A tower stands round by a small angle, and its carriage is twisted by as much; the
/// effector's joints stay as drawn. Three-rod formulas see a larger angle. Twist over
/// that angle:
///
///   delta radius / (delta radius + effector radius)
double TwistPerAngle(const DeltaModel<double>& drawn, double effector_radius_mm);

/// Stands a tower round by an angle (+ counter-clockwise from above): its rail and the
/// joints of its carriage turn about the machine's axis, the effector's do not. For
/// three-rod formulas it has another angle and radius, and its carriage is twisted.
/// Where no drawing states the effector, its joints turn too: the firmware's angle.
void StandRound(int tower, double angle_rad, DeltaBuild<double>* build);

/// The machine as drawn, but for what the settings say of it: where they have a tower
/// round by an angle, its carriage is twisted.
DeltaBuild<double> WithSettings(DeltaBuild<double> drawn,
                                const DeltaModel<double>& settings);

/// Of a number that each tower has, its mean.
double MeanOfTowers(const std::array<double, 3>& values);

/// What the settings of a delta say: the machine's axis through the bed's origin.
DeltaModel<double> SymmetricDelta(double endstop_mm, double radius_mm, double arm_mm);

/// Motor travel (down from the endstops) that puts the nozzle there, by three-rod
/// formulas. Not a number where an arm is too short.
template <typename T>
Vec3<T> DeltaMotors_mm(const DeltaModel<T>& model, const Vec3<T>& nozzle_mm);

/// The nozzle at these motor travels, by three-rod formulas (the lower intersection of
/// three spheres). Not a number where they do not meet.
template <typename T>
Vec3<T> DeltaNozzle_mm(const DeltaModel<T>& model, const Vec3<T>& motors_mm);

/// The exact pose of the six-rod chain at these motor travels: Newton's method to
/// rounding; with automatic differentiation the derivatives are exact. nullopt where it
/// does not close.
template <typename T>
std::optional<DeltaPose<T>> DeltaPoseOf(const DeltaBuild<T>& build,
                                        const Vec3<T>& motors_mm);

/// The motor travels that put the nozzle of the six-rod chain there.
std::optional<Vec3<double>> DeltaMotorsOf(const DeltaBuild<double>& build,
                                          const Vec3<double>& nozzle_mm);

}  // namespace caltwin

#include "sim/machine/kinds/delta/chain.h"  // IWYU pragma: export

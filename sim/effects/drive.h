#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "sim/effects/effect.h"
#include "sim/effects/linkage_at.h"
#include "sim/machine/kinds/delta/knobs.h"
#include "sim/machine/kinds/triple_z/drawing.h"

namespace caltwin {

/// What a drive moves: an axis of a cartesian machine, a tower's carriage, a screw, or,
/// with others, the axes of a CoreXY.
struct Drive {
  int index = 0;
  bool is_motor = false;  ///< In the `motor_` columns.
  bool is_screw = false;  ///< A motor's, under a bed.
  /// Its place in a machine's arrays of three.
  constexpr std::size_t slot() const { return static_cast<std::size_t>(index); }
};

/// "x" .. "z", "a" .. "c", "z1" .. "z3"; nullopt for anything else.
constexpr std::optional<Drive> DriveNamed(std::string_view name) {
  if (name.size() == 2 && name[0] == 'z' && name[1] >= '1' && name[1] <= '3') {
    return Drive{name[1] - '1', true, true};
  }
  if (name.size() != 1) return std::nullopt;
  if (name[0] >= 'x' && name[0] <= 'z') return Drive{name[0] - 'x', false};
  if (name[0] >= 'a' && name[0] <= 'c') return Drive{name[0] - 'a', true};
  return std::nullopt;
}

/// Its word as a covariate: "x", or "motor_a" (a screw's too).
inline std::string DriveCovariate(std::string_view name) {
  const Drive drive = DriveNamed(name).value();
  if (!drive.is_motor) return std::string(name);
  return std::string("motor_") + "abc"[drive.index];
}
/// The word of its sense: "dir_x", or "dir_a".
inline std::string SenseCovariate(std::string_view name) {
  const Drive drive = DriveNamed(name).value();
  return std::string("dir_") + (drive.is_motor ? "abc"[drive.index] : name[0]);
}

/// The axis over whose travel a drive goes: a screw under a bed over that of the
/// height.
inline const AxisDrawing& TravelOf(const Machine& machine, std::string_view name) {
  constexpr std::size_t kHeight = 2;
  const Drive drive = DriveNamed(name).value();
  return machine.axes[drive.is_screw ? kHeight : drive.slot()];
}

/// How high the screws under a bed are told to stand; nullopt: there are none.
inline std::optional<Vec3<double>> ScrewsOf_mm(const At& at) {
  if (!at.screws) return std::nullopt;
  const double up_mm = at.q_mm[2] - at.screws->stated_z_mm;
  return at.screws->stated_mm - Vec3<double>::Constant(up_mm);
}

/// What a row's motors are told: a tower's travel down from its endstop, a screw's
/// height over its, a belt's. nullopt on a machine that has no motors beside its axes.
inline std::optional<Vec3<double>> MotorsOf_mm(const At& at) {
  if (at.drives) return DrivesOf(at.drives->map, at.q_mm);
  if (at.linkage != nullptr) return at.linkage->motors_mm;
  return ScrewsOf_mm(at);
}
/// In which sense each of them came.
inline std::optional<Vec3<double>> MotorDirOf(const At& at) {
  if (at.drives) return at.drives->dir;
  if (at.linkage != nullptr) return at.linkage->motor_dir;
  if (!at.screws) return std::nullopt;
  return at.screws->motor_dir;
}

/// Where it stands by command [mm], motors as in MotorsOf_mm.
template <typename T>
T DriveAt_mm(const Asked<T>& asked) {
  const Drive drive = DriveNamed(asked.axis).value();
  if (!drive.is_motor) return asked.q_mm[drive.index];
  const auto motors_mm = drive.is_screw ? ScrewsOf_mm(asked.at) : MotorsOf_mm(asked.at);
  return T(motors_mm ? (*motors_mm)[drive.index] : 0.0);
}

/// What it moves further than commanded [mm], in its own sense.
template <typename T>
T& DriveError_mm(std::string_view axis, Errors<T>* errors) {
  const Drive drive = DriveNamed(axis).value();
  if (drive.is_screw) return errors->screw_mm[drive.index];
  return drive.is_motor ? errors->motor_mm[drive.index]
                        : errors->motion_mm[drive.index];
}

/// The sense in which that drive came.
inline double DriveSense(const At& at, int drive) {
  const bool is_coupled = at.drives && at.drives->map->is_coupled(drive);
  return is_coupled ? at.drives->dir[drive] : at.dir[drive];
}
/// What the drives' play takes from the tip.
inline Vec3<double> TakenByPlay_mm(const At& at, const Vec3<double>& lost_motion_mm) {
  Vec3<double> taken_mm;
  for (int i = 0; i < 3; ++i) taken_mm[i] = DriveSense(at, i) * lost_motion_mm[i] / 2;
  return AxesOf(at.drives ? at.drives->map : nullptr, taken_mm);
}

/// What carriages, and screws, move further than commanded: their errors and gaps, as
/// they last moved [mm].
template <typename T>
Vec3<T> MotorsMoved_mm(const Vec3<double>& motor_dir, const Errors<T>& errors) {
  return errors.motor_mm -
         motor_dir.cast<T>().cwiseProduct(errors.motor_lost_motion_mm) / T(2);
}

template <typename T>
Vec3<T> ScrewsMoved_mm(const Vec3<double>& screw_dir, const Errors<T>& errors) {
  return errors.screw_mm -
         screw_dir.cast<T>().cwiseProduct(errors.screw_lost_motion_mm) / T(2);
}

/// By how much less each screw's height counts over (x, y) where guides hold a bed
/// level and the screws give (OverconstrainedBed): in place of K^-1 sum d_i z_i the
/// tilt is
///
///   (K + held)^-1 sum d_i z_i
///
/// which takes from the weights
///
///   held d_i . (K (K + held))^-1 (p - middle),  K = sum d_i d_i^T
template <typename T>
Vec3<T> WeightsHeldBack(const Pivots<T>& built_mm,
                        const T& held_mm2,
                        const Eigen::Matrix<T, 2, 1>& at_mm) {
  using Flat = Eigen::Matrix<T, 2, 1>;
  const Flat middle_mm = (built_mm[0] + built_mm[1] + built_mm[2]) / T(3);
  Eigen::Matrix<T, 2, 2> spread = Eigen::Matrix<T, 2, 2>::Zero();
  for (const Flat& pivot_mm : built_mm) {
    const Flat from_mm = pivot_mm - middle_mm;
    spread += from_mm * from_mm.transpose();
  }
  Eigen::Matrix<T, 2, 2> stiffer = spread;
  stiffer(0, 0) += held_mm2;
  stiffer(1, 1) += held_mm2;
  const Eigen::Matrix<T, 2, 2> both = spread * stiffer;
  const Flat turned = both.inverse() * (at_mm - middle_mm);
  Vec3<T> weights;
  for (std::size_t i = 0; i < built_mm.size(); ++i) {
    const Flat from_mm = built_mm[i] - middle_mm;
    weights[static_cast<Eigen::Index>(i)] = held_mm2 * from_mm.dot(turned);
  }
  return weights;
}

/// By how much each screw's height counts in that of the bed there, the screws as
/// built and the bed held as it is.
template <typename T>
Vec3<T> BuiltWeights(const At& at, const Errors<T>& errors) {
  const Vec3<double> tip_mm = at.Tip_mm();
  Pivots<T> built_mm;
  for (std::size_t i = 0; i < built_mm.size(); ++i) {
    built_mm[i] = at.screws->drawn_mm[i].template cast<T>() +
                  errors.pivot_off_mm.col(static_cast<Eigen::Index>(i));
  }
  const T x_mm(tip_mm[0]), y_mm(tip_mm[1]);
  return ScrewWeights<T>(built_mm, x_mm, y_mm) -
         WeightsHeldBack<T>(built_mm, errors.held_mm2, {x_mm, y_mm});
}

/// How far a bed on screws truly stands lower there than the screws as drawn, told so,
/// have it.
///
///   dz = -(W . (told + moved) - w . told),  W of the screws as built, w as drawn
template <typename T>
Vec3<T> MotionOfScrews_mm(const At& at, const Errors<T>& errors) {
  if (!at.screws) return Vec3<T>::Zero();
  const Vec3<T> moved_mm = ScrewsMoved_mm(at.screws->motor_dir, errors);
  const Vec3<T> weights = BuiltWeights(at, errors);
  const Vec3<T> more = weights - at.screws->weights.template cast<T>();
  const Vec3<T> told_mm = ScrewsOf_mm(at)->template cast<T>();
  return {T(0), T(0), -(more.dot(told_mm) + weights.dot(moved_mm))};
}

/// How the nozzle follows its drives: by the map where they move the axes together, on
/// a delta through its chain.
template <typename T>
Vec3<T> MotionOfDrives_mm(const At& at, const Errors<T>& errors) {
  if (at.drives) {
    return at.drives->map->axes_by_drive.template cast<T>() * errors.motor_mm;
  }
  if (at.linkage == nullptr) return Vec3<T>::Zero();
  // A carriage that is lower is one whose endstop is.
  return -at.linkage->by_knob.middleCols<3>(kEndstopKnob).cast<T>() *
         MotorsMoved_mm(at.linkage->motor_dir, errors);
}

/// Both.
template <typename T>
Vec3<T> MotionOfMotors_mm(const At& at, const Errors<T>& errors) {
  return MotionOfDrives_mm(at, errors) + MotionOfScrews_mm(at, errors);
}

}  // namespace caltwin

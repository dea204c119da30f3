#pragma once

#include <cmath>
#include <span>

#include "sim/effects/catalog.h"
#include "sim/effects/drive.h"
#include "sim/effects/effect.h"
#include "sim/machine/kinds/z_station/drawing.h"

namespace caltwin {

/// All errors of a machine built with `effects`, at one place.
///
/// Two passes: the drive's effects see the commanded position; the later stages see
/// where the axes then truly stand (drive errors and lost motion added), so that a
/// squareness on a wrong scale is exact.
///
/// Over a bed on screws `at.screws` adds where the bed stands by its screws. Where
/// drives move the axes together, `at.drives` says how, and what a drive does wrong
/// acts through that. Where links lead to the tip, `at.linkage` says where the nozzle
/// stands beside its commanded place as the machine is believed to be built; effects
/// that turn its build are straight about that.
template <typename T>
Errors<T> ErrorsAt(const Machine& machine,
                   const At& at,
                   std::span<const Valued<T>> effects) {
  Errors<T> errors;
  for (const Axis axis : kAxes) {
    errors.steps_per_mm[Index(axis)] = T(machine.axis(axis).steps_per_mm());
  }
  for (auto& both : errors.pretravel_mm) both.fill(T(machine.probe.pretravel_mm));
  errors.tip_radius_mm = T(machine.probe.tip_radius_mm);
  const auto add = [&](bool drive, const Vec3<T>& q_mm) {
    for (const Valued<T>& effect : effects) {
      const Stage stage = EffectAt(effect.effect).stage;
      if ((stage == Stage::kDrive) != drive) continue;
      // A gauge that stands on the frame does not feel what the gantry does.
      if (stage == Stage::kFrame && at.screws && at.screws->is_fixed) continue;
      const Asked<T> asked{.p = effect.values,
                           .axis = effect.axis,
                           .machine = machine,
                           .at = at,
                           .q_mm = q_mm};
      AddErrors(effect.effect, asked, &errors);
    }
  };
  const Vec3<T> q_mm = at.q_mm.template cast<T>();
  add(/*drive=*/true, q_mm);
  if (at.linkage != nullptr) {
    errors.motion_mm += at.linkage->off_mm.template cast<T>();
    add(/*drive=*/false, Vec3<T>(q_mm + errors.motion_mm));
    errors.motion_mm += MotionOfMotors_mm(at, errors);
    return errors;
  }
  if (at.screws) {
    const int z = Index(Axis::kZ);
    if (at.steps_per_mm[z] > 0) {
      errors.screw_mm += ScrewsOf_mm(at)->template cast<T>() *
                         (T(at.steps_per_mm[z] / errors.steps_per_mm[z]) - 1.0);
    }
    errors.motion_mm[z] += at.screws->off_mm;
    errors.motion_mm += MotionOfScrews_mm(at, errors);
  }
  const DrivesAt* drives = at.drives ? &*at.drives : nullptr;
  const Vec3<double> told_mm = drives ? DrivesOf(drives->map, at.q_mm) : at.q_mm;
  Vec3<T>& moved_mm = drives ? errors.motor_mm : errors.motion_mm;
  for (const Axis axis : kAxes) {
    const int i = Index(axis);
    // A bed's screws have had theirs.
    const bool is_screws = at.screws && axis == Axis::kZ;
    if (at.steps_per_mm[i] > 0 && !is_screws) {
      const double home_mm = drives ? drives->home_mm[i] : machine.axis(axis).home_mm();
      moved_mm[i] += (told_mm[i] - home_mm) *
                     (T(at.steps_per_mm[i] / errors.steps_per_mm[i]) - 1.0);
    }
    const double sense = DriveSense(at, i);
    const double compensation_mm = at.compensation_mm[i];
    moved_mm[i] -= sense * (errors.lost_motion_mm[i] - compensation_mm) / 2.0;
  }
  if (drives) errors.motion_mm += MotionOfDrives_mm(at, errors);
  add(/*drive=*/false, Vec3<T>(q_mm + errors.motion_mm));
  return errors;
}

/// Deflection of the stylus at the trigger on a surface of outward normal n:
/// 1 / sqrt(sum (n_i / p_i)^2), p_i of the sense in which the machine pushes (-n_i).
template <typename T>
T Pretravel_mm(const Errors<T>& errors, const Vec3<double>& n) {
  using std::sqrt;
  T sum(0);
  for (int i = 0; i < 3; ++i) {
    const T& p_mm = errors.pretravel_mm[static_cast<std::size_t>(i)][n[i] < 0 ? 0 : 1];
    const T ratio = n[i] / p_mm;
    sum += ratio * ratio;
  }
  return 1.0 / sqrt(sum);
}

/// What the parts of a printer's station add to a reading there.
///
///   nozzle on switch: nozzle + ooze,  body on switch: nothing,
///   probe on bed: surface + trigger - more pre-travel
///   gap under the nozzle, calibrated just before: trigger - more pre-travel + ooze
///
/// How long the body is, and how far the head is off, a calibration takes out.
template <typename T>
T StationPart_mm(ZReading reading, const Errors<T>& errors) {
  const T knob_mm = errors.trigger_mm - errors.more_pretravel_mm;
  switch (reading) {
    case ZReading::kNozzleOnSwitch:
      return errors.nozzle_mm + errors.ooze_mm;
    case ZReading::kBodyOnSwitch:
      break;
    case ZReading::kProbeOnBed:
      return errors.artefact_mm + knob_mm;
    case ZReading::kGapUnderNozzle:
      return knob_mm + errors.ooze_mm;
  }
  return T(0);
}

/// A reading with these errors, pre-travel and configured tip radius given: what
/// Value_mm gives, and what one more effect changes.
template <typename T>
T ReadWith_mm(const At& at,
              const Errors<T>& errors,
              const T& pretravel_mm,
              double tip_radius_cfg_mm) {
  T along_mm = errors.motion_mm.dot(at.n.template cast<T>());
  if (at.station) {
    const T part_mm = StationPart_mm(*at.station, errors);
    return at.kind == RowKind::kTouch ? part_mm - along_mm : part_mm;
  }
  if (at.kind != RowKind::kTouch) {
    return at.screws ? along_mm - errors.artefact_mm : along_mm;
  }
  return -along_mm - pretravel_mm - errors.more_pretravel_mm -
         at.feed_mm_s * errors.latency_s + (errors.tip_radius_mm - tip_radius_cfg_mm) +
         errors.artefact_mm;
}

/// The one measurement model: `value_mm` of a row taken at `at` on a machine built with
/// `effects`. Fast fidelity, estimates, atlas and diagnosis all come from ErrorsAt.
///
///   position, radial:  motion . n
///   touch:  -motion . n - pre-travel - v tau + (R_true - R_cfg) + artefact
///   at a printer's station: -motion . n + StationPart_mm; of a gap without motion
///
/// Motion contains the lost motion not compensated, -dir (b - compensation) / 2. On a
/// triple-Z printer a gauge reads how far the nozzle is from the bed, so that
/// position = motion . n - artefact.
template <typename T>
T Value_mm(const At& at, const Errors<T>& errors) {
  const bool bends = at.kind == RowKind::kTouch && !at.station;
  const T pretravel_mm = bends ? Pretravel_mm(errors, at.n) : T(0);
  return ReadWith_mm(at, errors, pretravel_mm, at.tip_radius_cfg_mm);
}

template <typename T>
T Predict_mm(const Machine& machine, const At& at, std::span<const Valued<T>> effects) {
  return Value_mm(at, ErrorsAt(machine, at, effects));
}

/// The effect with the values that change nothing on this machine.
Injected NeutralEffect(int effect, std::string_view axis, const Machine& machine);

}  // namespace caltwin

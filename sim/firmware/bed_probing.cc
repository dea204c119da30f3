// A bed that is touched (G30), and levelled by the screws it stands on (M671, M584).
#include "sim/firmware/bed_probing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include <fmt/format.h>

#include "sim/firmware/parts.h"

namespace caltwin {
namespace {

constexpr double kDive_mm = 5;  // M558 H: over the bed, before and after a touch.
constexpr double kRapid_mm_s = std::numeric_limits<double>::infinity();
constexpr double kNotMeasured_mm = -9999;  // G30 Z below it: probe there.
// How far beyond z's travel a touch, or a screw moved singly, may go.
constexpr double kDeepest_mm = kDive_mm;
constexpr std::string_view kSplitLetters = "ZUV";

bool IsInside(const Machine& machine, Axis axis, double mm) {
  constexpr double kSlack_mm = 1e-2;  // Places are those of whole steps.
  const AxisDrawing& drawing = machine.axis(axis);
  return mm >= drawing.min_mm - kSlack_mm && mm <= drawing.max_mm + kSlack_mm;
}

}  // namespace

bool Firmware::Parts::IsHomed() const {
  return std::ranges::all_of(kAxes, [&](Axis axis) { return motion.is_homed(axis); });
}

// By the steps/mm that the machine began with: M92 moves no screw.
Vec3<double> Firmware::Parts::Raised_mm() const {
  const Vec3<double> up_mm = -motion.z_zero_steps() / initial_settings.steps_per_mm[2];
  return up_mm.array() - machine.axis(Axis::kZ).max_mm;
}

Reply Firmware::Parts::ProbeBed(const Words& words) {
  if (!IsHomed()) return Refuse("G30: insufficient axes homed");
  if (bed.is_split) return Refuse("G30: the drivers of Z are not joined");
  if (!HasProbe()) return Refuse("G30: no Z probe is configured");
  if (!IsInside(machine, Axis::kZ, kDive_mm)) {
    return Refuse("G30: the dive height is outside the travel of Z");
  }
  motion.Finish();
  Vec3<double> over_mm = motion.commanded_mm();
  for (const Axis axis : {Axis::kX, Axis::kY}) {
    const auto word_mm = words.Number(CapitalLetter(axis));
    if (!word_mm) continue;
    if (!IsInside(machine, axis, *word_mm)) {
      return Refuse("G30: probe point is outside the travel of X and Y");
    }
    over_mm[Index(axis)] = *word_mm;
  }
  const auto point = words.Whole('P', 0, std::numeric_limits<int>::max());
  const auto factors = words.Number('S');
  const auto stated_mm = words.Number('Z');
  if (point && static_cast<std::size_t>(*point) > bed.points.size()) {
    return Refuse("G30: Z probe point index out of range");
  }
  double height_mm = stated_mm.value_or(0);
  if (!point || !stated_mm || *stated_mm <= kNotMeasured_mm) {
    std::string why_not;
    const auto touched_mm = TouchBed(over_mm, &why_not);
    if (!touched_mm) return why_not.empty() ? Reply{} : Refuse(why_not);
    height_mm = *touched_mm;
    // Alone it says where Z is.
    if (!point && !factors) motion.SetPosition(Axis::kZ, 0);
    over_mm[2] = kDive_mm;
    motion.MoveTo(over_mm, kRapid_mm_s);
    motion.Finish();
  }
  if (!point) {
    return {.lines = {fmt::format("Stopped at height {:.3f} mm", height_mm)}};
  }
  // Whatever was kept from there on is forgotten; P0 begins anew.
  bed.points.resize(static_cast<std::size_t>(*point));
  bed.points.push_back({over_mm.head<2>(), height_mm});
  if (factors && *factors >= 0) return AdjustLeadscrews();
  return {};
}

std::optional<double> Firmware::Parts::TouchBed(Vec3<double> over_mm,
                                                std::string* why_not) {
  Vec3<double> up_mm = motion.commanded_mm();
  up_mm[2] = over_mm[2] = kDive_mm;
  motion.MoveTo(up_mm, kRapid_mm_s);
  motion.MoveTo(over_mm, kRapid_mm_s);
  motion.Dwell(options.probe_recovery_s);
  if (motion.alarm()) return std::nullopt;
  if (ProbeReads()) {
    *why_not = "Probe already triggered before probing move started";
    return std::nullopt;
  }
  const double slow_mm_s = machine.probe.speeds_mm_s.back();
  over_mm[2] = machine.axis(Axis::kZ).min_mm - kDeepest_mm;
  const bool is_found =
      motion.Probe(over_mm, slow_mm_s, WatchOf(Watch::Kind::kProbeTriggered)).stopped;
  if (!is_found) {
    if (!motion.alarm()) *why_not = "Probe was not triggered during probing move";
    return std::nullopt;
  }
  const double stopped_mm = motion.counted_mm()[2] + 0.0;
  bed.probed.push_back({.at_mm = over_mm.head<2>(),
                        .stopped_mm = stopped_mm,
                        .raised_mm = Raised_mm(),
                        .steps_per_mm = settings.steps_per_mm[2],
                        .backlash_mm = settings.backlash_mm[2],
                        .feed_mm_s = slow_mm_s,
                        .at_s = motion.time_s(),
                        .homing = bed.homings});
  return stopped_mm;
}

Reply Firmware::Parts::AdjustLeadscrews() {
  if (!bed.leadscrews) {
    return Refuse("G30: Leadscrews are not defined, use M671");
  }
  const auto corrections = LevelScrews(bed.leadscrews->at_mm, bed.points);
  const std::size_t count = bed.points.size();
  bed.points.clear();
  if (!corrections) return Refuse("Bed calibration: 3 points apart are needed");
  const Vec3<double> raise_mm = corrections->raise_mm;
  if (raise_mm.cwiseAbs().maxCoeff() > bed.leadscrews->largest_mm) {
    return Refuse(fmt::format(
        "Some computed corrections exceed configured limit of {:.2f}mm: {:.3f} {:.3f} "
        "{:.3f}",
        bed.leadscrews->largest_mm,
        raise_mm[0],
        raise_mm[1],
        raise_mm[2]));
  }
  // A screw that lifts the bed is a shorter way down.
  const Vec3<double> by_mm = -raise_mm;
  motion.MoveSingly(by_mm, kRapid_mm_s);
  return {
      .lines = {fmt::format(
          "Leadscrew adjustments made: {:.3f} {:.3f} {:.3f}, points used {}, (mean, "
          "deviation) before ({:.3f}, {:.3f}) after ({:.3f}, {:.3f})",
          raise_mm[0],
          raise_mm[1],
          raise_mm[2],
          count,
          corrections->mean_before_mm,
          corrections->deviation_before_mm,
          corrections->mean_after_mm,
          corrections->deviation_after_mm)}};
}

Reply Firmware::Parts::SetLeadscrews(const Words& words) {
  if (!bed.leadscrews) return Refuse("M671: this bed does not stand on leadscrews");
  const auto x = words.Numbers('X'), y = words.Numbers('Y');
  const auto largest_mm = words.Number('S');
  if (!x && !y && !largest_mm) {
    const Pivots<double>& at = bed.leadscrews->at_mm;
    return {.lines = {fmt::format(
                "leadscrews at ({:.1f}, {:.1f}), ({:.1f}, {:.1f}), ({:.1f}, {:.1f}), "
                "maximum correction {:.2f}mm",
                at[0][0],
                at[0][1],
                at[1][0],
                at[1][1],
                at[2][0],
                at[2][1],
                bed.leadscrews->largest_mm)}};
  }
  if (largest_mm && *largest_mm <= 0) return Refuse("M671: S needs a number above 0");
  if (x || y) {
    Pivots<double> pivots_mm;
    if (!x || !y || x->size() != pivots_mm.size() || y->size() != pivots_mm.size()) {
      return Refuse("M671: X and Y need three numbers each, X20:215:20");
    }
    for (std::size_t i = 0; i < pivots_mm.size(); ++i)
      pivots_mm[i] = {(*x)[i], (*y)[i]};
    if (TriangleShape(pivots_mm) < kFlattestTriangle) {
      return Refuse("M671: the leadscrews stand nearly in one line");
    }
    bed.leadscrews->at_mm = pivots_mm;
  }
  if (largest_mm) bed.leadscrews->largest_mm = *largest_mm;
  return {};
}

// The documented way to move drivers of one axis singly: `M584 Z0 U1 V2 P5` gives each
// an axis of its own, `M584 Z0:1:2 P3` joins them again.
Reply Firmware::Parts::SetDrivers(const Words& words) {
  if (motion.num_z_motors() != 3) return Refuse("M584: each axis has one driver here");
  const auto z = words.Numbers('Z'), u = words.Numbers('U'), v = words.Numbers('V');
  const bool joins = z == std::vector<double>{0, 1, 2} && !u && !v;
  const bool splits = z == std::vector<double>{0} && u == std::vector<double>{1} &&
                      v == std::vector<double>{2};
  if (!joins && !splits) return Refuse("M584: Z0 U1 V2 P5, or Z0:1:2 P3, here");
  if (splits == bed.is_split) return {};
  motion.Finish();
  // New axes stand at 0 and are not homed before G92 says where they are; drivers that
  // join an axis stand where it does.
  if (joins) {
    motion.FollowFirst();
    motion.SetPosition(Axis::kZ, bed.split_mm[0]);
    if (!bed.are_placed[0]) motion.Unhome(Axis::kZ);
  } else {
    bed.split_mm = {motion.commanded_mm()[2], 0, 0};
    bed.are_placed = {motion.is_homed(Axis::kZ), false, false};
  }
  bed.is_split = splits;
  return {};
}

bool Firmware::Parts::MayStand(const Vec3<double>& z_mm) const {
  if (motion.num_z_motors() == 1) return true;
  const AxisDrawing& z = machine.axis(Axis::kZ);
  const Vec3<double> stand_mm = z_mm + motion.beside_mm();
  return stand_mm.minCoeff() >= z.min_mm - kDeepest_mm &&
         stand_mm.maxCoeff() <= z.max_mm + kDeepest_mm;
}

// Of Z, U and V while each is an axis. Only Z has a work offset.
std::string_view Firmware::Parts::SplitTarget(const Words& words,
                                              Vec3<double>* to_mm) const {
  *to_mm = bed.split_mm;
  for (int i = 0; i < 3; ++i) {
    const auto word_mm = words.Number(kSplitLetters[static_cast<std::size_t>(i)]);
    if (!word_mm) continue;
    if (!bed.are_placed[static_cast<std::size_t>(i)]) return "insufficient axes homed";
    const bool has_offset = i == 0 && !uses_machine_coordinates;
    (*to_mm)[i] = is_relative ? bed.split_mm[i] + *word_mm
                              : *word_mm + (has_offset ? offset_mm()[2] : 0);
  }
  const Vec3<double> z_mm =
      Vec3<double>::Constant(motion.commanded_mm()[2]) + *to_mm - bed.split_mm;
  return MayStand(z_mm) ? "" : "target position outside machine limits";
}

void Firmware::Parts::MoveSplit(const Vec3<double>& to_mm) {
  Vec3<double> by_mm = to_mm - bed.split_mm;
  if (options.still_alone) by_mm[*options.still_alone] = 0;
  motion.MoveSingly(by_mm, is_rapid ? kRapid_mm_s : feed_mm_s);
  bed.split_mm = to_mm;
}

void Firmware::Parts::PlaceSplit(const Words& words) {
  for (int i = 0; i < 3; ++i) {
    const auto to_mm = words.Number(kSplitLetters[static_cast<std::size_t>(i)]);
    if (!to_mm) continue;
    bed.split_mm[i] = *to_mm + (i == 0 ? offset_mm()[2] : 0);
    bed.are_placed[static_cast<std::size_t>(i)] = true;
  }
}

Reply Firmware::Parts::ReportEndstops(const Words&) {
  motion.Finish();
  std::string line = "Endstops -";
  for (const Axis axis : kAxes) {
    const bool is_min = machine.axis(axis).home == HomeEnd::kMin;
    line += fmt::format(" {}: {},",
                        CapitalLetter(axis),
                        !plant->SwitchClosed(axis) ? "not stopped"
                        : is_min                   ? "at min stop"
                                                   : "at max stop");
  }
  line += fmt::format(" Z probe: {}", ProbeReads() ? "at min stop" : "not stopped");
  return {.lines = {line}};
}

}  // namespace caltwin

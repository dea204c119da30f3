#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/firmware/parts.h"

namespace caltwin {
namespace {

constexpr double kLimitSlack_mm = 1e-3;  // Less than any axis resolves.

bool NamesAxis(const rrf::Words& words) {
  return words.Has('X') || words.Has('Y') || words.Has('Z');
}

// Beyond what any machine has, and any number of steps.
bool IsFar(const rrf::Words& words) {
  constexpr double kFarthest_mm = 1e6;
  return std::ranges::any_of(std::string_view("XYZUV"), [&](char letter) {
    return std::abs(words.Number(letter).value_or(0)) > kFarthest_mm;
  });
}

// Axes of single drivers, see M584.
bool NamesDriver(const rrf::Words& words) {
  return words.Has('U') || words.Has('V');
}

}  // namespace

Vec3<double> Firmware::Parts::Target_mm(const Words& words) const {
  Vec3<double> target_mm = motion.commanded_mm();
  for (const Axis axis : kAxes) {
    const auto word_mm = words.Number(CapitalLetter(axis));
    if (!word_mm || (bed.is_split && axis == Axis::kZ)) continue;
    double& coordinate_mm = target_mm[Index(axis)];
    if (is_relative) {
      coordinate_mm += *word_mm;
    } else if (uses_machine_coordinates) {
      coordinate_mm = *word_mm;
    } else {
      coordinate_mm = *word_mm + offset_mm()[Index(axis)];
    }
  }
  return target_mm;
}

std::string_view Firmware::Parts::Refusal(const Words& words,
                                          const Vec3<double>& target_mm) const {
  // A single driver's axis has its own place, see M584.
  const auto is_named = [&](Axis axis) {
    return words.Has(CapitalLetter(axis)) && !(bed.is_split && axis == Axis::kZ);
  };
  for (const Axis axis : kAxes) {
    if (is_named(axis) && !motion.is_homed(axis)) return "insufficient axes homed";
  }
  for (const Axis axis : kAxes) {
    const AxisDrawing& drawing = machine.axis(axis);
    const double mm = target_mm[Index(axis)];
    if (is_named(axis) && (mm < drawing.min_mm - kLimitSlack_mm ||
                           mm > drawing.max_mm + kLimitSlack_mm)) {
      return "target position outside machine limits";
    }
  }
  if (is_named(Axis::kZ) && !MayStand(Vec3<double>::Constant(target_mm[2]))) {
    return "target position outside machine limits";
  }
  return "";
}

Reply Firmware::Parts::MoveLinear(const GcodeCommand& command, const Words& words) {
  if (command.letter == 'G') is_rapid = command.code == 0;
  if (words.Has('H') && words.Number('H') != 0.0) {
    return Refuse("G0/G1: H moves are not part of this machine");
  }
  if (const auto feed = words.Number('F')) {
    if (*feed <= 0) return Refuse("G0/G1: feed rate must be above 0");
    feed_mm_s = FeedFromWord_mm_s(*feed);
  }
  if (NamesDriver(words) && !bed.is_split && motion.num_z_motors() > 1) {
    return Refuse("G0/G1: there are no axes U and V before M584");
  }
  if (!NamesAxis(words) && !(bed.is_split && NamesDriver(words))) return {};
  const Vec3<double> target_mm = Target_mm(words);
  std::string_view refusal = Refusal(words, target_mm);
  Vec3<double> split_mm = Vec3<double>::Zero();
  if (refusal.empty() && bed.is_split) refusal = SplitTarget(words, &split_mm);
  if (!refusal.empty()) return Refuse(fmt::format("G0/G1: {}", refusal));
  motion.MoveTo(target_mm,
                is_rapid ? std::numeric_limits<double>::infinity() : feed_mm_s);
  if (bed.is_split) MoveSplit(split_mm);
  return {};
}

Reply Firmware::Parts::Dwell(const Words& words) {
  const double seconds = words.Number('S').value_or(0);
  const double milliseconds = words.Number('P').value_or(0);
  motion.Dwell(seconds + SFromMs(milliseconds));
  motion.Recompute(options.m400_ignores_backlash);
  return {};
}

Reply Firmware::Parts::WaitForMoves(const Words&) {
  motion.Recompute(options.m400_ignores_backlash);
  return {};
}

Reply Firmware::Parts::Home(const Words& words) {
  motion.Finish();
  for (const Axis axis : {Axis::kZ, Axis::kX, Axis::kY}) {
    if (NamesAxis(words) && !words.Has(CapitalLetter(axis))) continue;
    if (motion.alarm()) break;
    if (axis == Axis::kZ) {
      bed.is_split = false;
      bed.points.clear();
    }
    if (!motion.Home(axis)) {
      return Refuse(fmt::format("G28: Failed to home axes {}", CapitalLetter(axis)));
    }
    if (axis == Axis::kZ) ++bed.homings;
  }
  return {};
}

Reply Firmware::Parts::Probe(const GcodeCommand& command, const Words& words) {
  if (command.minor < 2 || command.minor > 5) {
    return {.lines = {
                fmt::format("Warning: {}: Command is not supported", command.Name())}};
  }
  if (!NamesAxis(words)) return Refuse(command.Name() + ": no axis specified");
  if (bed.is_split) return Refuse(command.Name() + ": the drivers of Z are not joined");
  if (!HasProbe()) return Refuse(command.Name() + ": no Z probe is configured");
  const double slow_mm_s = machine.probe.speeds_mm_s.back();
  const auto feed_word = words.Number('F');
  if (feed_word && *feed_word <= 0) {
    return Refuse(command.Name() + ": feed rate must be above 0");
  }
  motion.Finish();
  if (motion.alarm()) return {};
  const Vec3<double> target_mm = Target_mm(words);
  const std::string_view refusal = Refusal(words, target_mm);
  if (!refusal.empty()) return Refuse(fmt::format("{}: {}", command.Name(), refusal));

  const bool goes_away = command.minor >= 4;
  if (ProbeReads() != goes_away) {
    return Refuse(goes_away ? "Probe not triggered before probing move started"
                            : "Probe already triggered before probing move started");
  }
  const Motion::Probed probed = motion.Probe(
      target_mm,
      feed_word ? FeedFromWord_mm_s(*feed_word) : slow_mm_s,
      WatchOf(goes_away ? Watch::Kind::kProbeReleased : Watch::Kind::kProbeTriggered));
  const bool must_find = command.minor == 2 || command.minor == 4;
  if (!probed.stopped && must_find && !motion.alarm()) {
    return Refuse(goes_away ? "Probe did not lose contact during probing move"
                            : "Probe was not triggered during probing move");
  }
  return {};
}

Reply Firmware::Parts::SetPosition(const Words& words) {
  motion.Finish();
  if (motion.alarm()) return {};
  if (IsFar(words)) return Refuse("G92: a position lies within 1000000 mm");
  if (bed.is_split) PlaceSplit(words);
  for (const Axis axis : kAxes) {
    if (bed.is_split && axis == Axis::kZ) continue;
    if (const auto mm = words.Number(CapitalLetter(axis))) {
      motion.SetPosition(axis, *mm + offset_mm()[Index(axis)]);
    }
  }
  return {};
}

Reply Firmware::Parts::SetWorkOffset(const Words& words) {
  const auto kind = words.Number('L');
  if (!kind || (*kind != 2 && *kind != 20)) {
    return Refuse("G10: only L2 and L20, work offsets, are part of this machine");
  }
  if (IsFar(words)) return Refuse("G10: an offset lies within 1000000 mm");
  const int named = words.Whole('P', 0, kWorkplaces).value_or(0);
  Vec3<double>& offset = workplaces_mm[named == 0 ? workplace : named - 1];
  if (*kind == 20) motion.Finish();
  Vec3<double> here_mm = motion.commanded_mm();
  if (bed.is_split) here_mm[2] = bed.split_mm[0];
  for (const Axis axis : kAxes) {
    if (const auto mm = words.Number(CapitalLetter(axis))) {
      offset[Index(axis)] = *kind == 2 ? *mm : here_mm[Index(axis)] - *mm;
    }
  }
  return {};
}

Reply Firmware::Parts::SelectWorkplace(const GcodeCommand& command) {
  const int index = command.code - 54 + command.minor;
  if (index >= kWorkplaces || (command.minor > 0 && command.code != 59)) {
    return {.lines = {
                fmt::format("Warning: {}: Command is not supported", command.Name())}};
  }
  workplace = index;
  return {};
}

Reply Firmware::Parts::EmergencyStop(const Words&) {
  motion.Abandon();
  halted = true;
  return {.lines = {"Emergency Stop! Reset the controller to continue."},
          .error = true};
}

Reply Firmware::Parts::MotorsOff(const Words& words) {
  motion.Finish();
  for (const Axis axis : kAxes) {
    if (NamesAxis(words) && !words.Has(CapitalLetter(axis))) continue;
    motion.Unhome(axis);
    if (axis == Axis::kZ) bed.are_placed.fill(false);
  }
  return {};
}

}  // namespace caltwin

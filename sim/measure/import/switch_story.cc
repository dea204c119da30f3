#include "sim/measure/import/switch_story.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/units.h"
#include "sim/measure/import/fields.h"

namespace caltwin {
namespace {

// A hint stands behind its calibration, or before it where the newest line is first:
// both print the same offset.
bool AreAlike(double one_mm, double other_mm) {
  constexpr double kSame_mm = 1e-6;
  return std::abs(one_mm - other_mm) < kSame_mm;
}

}  // namespace

bool SwitchStory::Take(const ConsoleLine& line, int number) {
  if (line.lower.find("hint:") != std::string::npos) {
    const auto endstop_mm = NumberAfter(line.lower, "position_endstop="),
               offset_mm = NumberAfter(line.lower, " offset=");
    if (!endstop_mm || !offset_mm) return endstop_mm.has_value();
    hints_.push_back({*offset_mm, *endstop_mm});
    for (Calibration& one : all_) {
      if (AreAlike(one.offset_mm, *offset_mm)) one.endstop_mm = *endstop_mm;
    }
    return true;
  }
  if (line.lower.find("z-calibration:") == std::string::npos) return false;
  const auto nozzle_mm = NumberAfter(line.lower, "nozzle="),
             body_mm = NumberAfter(line.lower, "switch="),
             probe_mm = NumberAfter(line.lower, "probe=");
  if (!nozzle_mm || !body_mm || !probe_mm) return false;
  all_.push_back(
      {.nozzle_mm = *nozzle_mm,
       .body_mm = *body_mm,
       .probe_mm = *probe_mm,
       .offset_mm = NumberAfter(line.lower, "new offset=").value_or(kUnknown),
       .line = number});
  for (const Hint& hint : hints_) {
    if (AreAlike(hint.offset_mm, all_.back().offset_mm))
      all_.back().endstop_mm = hint.endstop_mm;
  }
  return true;
}

bool SwitchStory::HasOtherEndstops() const {
  double first_mm = kUnknown;
  for (const Calibration& one : all_) {
    if (!Known(one.endstop_mm)) continue;
    if (Known(first_mm) && one.endstop_mm != first_mm) return true;
    first_mm = one.endstop_mm;
  }
  return false;
}

void SwitchStory::Tell(Imported* imported) const {
  // Under one endstop they are repeats, and told as such.
  if (all_.size() < 2 || !HasOtherEndstops()) return;
  TellDistance(imported);
  TellHint(imported);
}

// Klipper's z_calibration: offset = probe - (switch - nozzle + switch_offset).
void SwitchStory::TellDistance(Imported* imported) const {
  constexpr double kRepeats_mm = 0.1;
  std::vector<double> apart_mm;
  for (const Calibration& one : all_) apart_mm.push_back(one.body_mm - one.nozzle_mm);
  const auto [least, most] = std::ranges::minmax_element(apart_mm);
  const double change_mm = *most - *least;
  if (change_mm < kRepeats_mm) return;
  double least_probe_mm = all_.front().probe_mm, most_probe_mm = least_probe_mm;
  for (const Calibration& one : all_) {
    least_probe_mm = std::min(least_probe_mm, one.probe_mm);
    most_probe_mm = std::max(most_probe_mm, one.probe_mm);
  }
  imported->notes.push_back(
      {.kind = FileNote::Kind::kOpen,
       .what = "cause",
       .sentence = fmt::format(
           "which touch on the pin was another: switch less nozzle, a distance that is "
           "fixed in the toolhead, is {:.3f} mm, changes by {:.2f} mm, and the offset "
           "moves by as much.{} Look at what meets the pin: how the probe sits in its "
           "dock, "
           "which part of its body touches, dirt on the nozzle",
           fmt::join(apart_mm, ", "),
           change_mm,
           most_probe_mm - least_probe_mm < kRepeats_mm
               ? fmt::format(" Touches of the bed agree to {:.3f} mm, so probe and bed "
                             "are not it.",
                             most_probe_mm - least_probe_mm)
               : ""),
       .fact = "contradiction",
       .axis = "z",
       .word = "switch",
       .figures = {{"change_um", UmFromMm(change_mm)}}});
}

// The hint adds the offset to the endstop, and comes to an end only where readings
// follow it.
void SwitchStory::TellHint(Imported* imported) const {
  constexpr double kFollows = 0.3, kRaised_mm = 0.1;
  const Calibration *first = nullptr, *last = nullptr;
  for (const Calibration& one : all_) {
    if (!Known(one.endstop_mm)) continue;
    if (first == nullptr) first = &one;
    last = &one;
  }
  if (first == nullptr) return;
  const double raised_mm = last->endstop_mm - first->endstop_mm;
  const double moved_mm = last->nozzle_mm - first->nozzle_mm;
  const bool follows = std::abs(moved_mm) > kFollows * std::abs(raised_mm);
  if (std::abs(raised_mm) < kRaised_mm || follows) return;
  imported->notes.push_back(
      {.kind = FileNote::Kind::kSetting,
       .what = "position_endstop",
       .sentence = fmt::format(
           "position_endstop was raised by {:.3f} mm and the nozzle's reading moved by "
           "{:.3f} mm: the readings do not follow it, so the hint asks for ever more "
           "and never ends. Leave it, and find out which switch Z is homed to",
           raised_mm,
           moved_mm),
       .place = {.line = last->line, .column = 1}});
}

}  // namespace caltwin

// Where a grbl says that it is, against where it was told to go or touched.

#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/measure/import/grbl_story.h"

namespace caltwin {
namespace {

constexpr const char* kAxisLetters = "xyz";

}  // namespace

// Positions are kept in steps and told in mm: none is off by more than half a step.
void GrblStory::TellSteps(Imported* imported) const {
  constexpr double kPrinted_mm = 1e-3, kSame_mm = 4e-4;
  std::size_t num_rounded = 0;
  const Reported* worst = nullptr;
  for (const Reported& move : moves_) {
    const double step_mm = 1 / steps_per_mm_[move.axis];
    if (!Known(step_mm)) return;
    const double off_mm = std::abs(move.moved_mm - move.told_mm);
    const double whole_mm = std::round(move.at_mm / step_mm) * step_mm;
    if (off_mm > step_mm + kPrinted_mm || std::abs(whole_mm - move.at_mm) > kPrinted_mm)
      return;
    num_rounded += off_mm > kSame_mm ? 1 : 0;
    if (worst == nullptr || off_mm > std::abs(worst->moved_mm - worst->told_mm))
      worst = &move;
  }
  if (num_rounded < 2) return;
  const double steps = steps_per_mm_[worst->axis];
  imported->notes.push_back(
      {.kind = FileNote::Kind::kElsewhere,
       .what = "settings",
       .sentence = fmt::format(
           "The position is a whole number of steps: at {:g} steps/mm one step is "
           "{:.3g} "
           "um, and a move of {:g} mm is {:g} steps. What is reported is never off by "
           "more "
           "than half a step and does not add up. Nothing is wrong; more steps/mm, if "
           "that matters",
           steps,
           UmFromMm(1 / steps),
           worst->told_mm,
           worst->told_mm * steps)});
}

// A touch is reported where the counter stood: the whole step nearest to what was told.
void GrblStory::TellPlaces(Imported* imported) const {
  constexpr double kPrinted_mm = 1e-3, kSame_mm = 4e-4;
  std::size_t num_rounded = 0;
  const Reported* worst = nullptr;
  const auto off_mm = [](const Reported& place) {
    return std::abs(place.at_mm - place.told_mm);
  };
  for (const Reported& place : places_) {
    const double step_mm = 1 / steps_per_mm_[place.axis];
    if (!Known(step_mm)) return;
    const double whole_mm = std::round(place.told_mm / step_mm) * step_mm;
    if (std::abs(whole_mm - place.at_mm) > kPrinted_mm) return;
    num_rounded += off_mm(place) > kSame_mm ? 1 : 0;
    if (worst == nullptr || off_mm(place) > off_mm(*worst)) worst = &place;
  }
  if (num_rounded < 2) return;
  const double steps = steps_per_mm_[worst->axis];
  imported->notes.push_back(
      {.kind = FileNote::Kind::kElsewhere,
       .what = "firmware",
       .sentence = fmt::format(
           "Every reported place is the whole step nearest to the one told: at {:g} "
           "steps/mm a step is {:.3g} um, {}{:g} is {:.2f} steps, and {:.0f} steps are "
           "{:.3f} mm. Nothing more than half a step is off, so no steps are lost, and "
           "this shows neither play nor wrong steps/mm: the controller reports what it "
           "counted. A sender that asks for the very place told is too strict; let it "
           "allow half a step",
           steps,
           UmFromMm(1 / steps),
           "XYZ"[worst->axis],
           worst -> told_mm,
           worst -> told_mm* steps,
           std::round(worst->told_mm * steps),
           worst -> at_mm),
       .fact = "steps",
       .axis = std::string(1, kAxisLetters[worst->axis]),
       .figures = {{"step_um", UmFromMm(1 / steps)},
                   {"off_um", UmFromMm(off_mm(*worst))}}});
}

// It stops as far behind each contact as it takes to halt.
void GrblStory::TellRest(Imported* imported) const {
  constexpr double kLeast_mm = 0.003, kAlike = 0.3;
  if (beyond_mm_.size() < 2 || zeros_mm_.size() >= 2) return;
  const auto [least, most] = std::ranges::minmax(beyond_mm_);
  if (least < kLeast_mm || most - least > kAlike * most) return;
  const double feed_mm_s = MmPerSFromMmPerMin(probing_mm_min_);
  const std::string by_feed = Known(feed_mm_s)
                                  ? fmt::format(": at F{:g} that is {:.2f} s of travel",
                                                probing_mm_min_,
                                                (least + most) / 2 / feed_mm_s)
                                  : "";
  imported->notes.push_back(
      {.kind = FileNote::Kind::kElsewhere,
       .what = "settings",
       .sentence = fmt::format(
           "[PRB] is the place of the contact, MPos the place where the axis came to "
           "rest: {:.0f} to {:.0f} um further in the sense of the probing, {} times "
           "alike. It has to halt first, and empties what was planned{}. Set the zero "
           "by [PRB], or add what it ran on. It is no play, no scatter of the probe "
           "and no fault of steps/mm",
           UmFromMm(least),
           UmFromMm(most),
           beyond_mm_.size(),
           by_feed),
       .fact = "offset",
       .word = "overtravel",
       .figures = {{"change_um", UmFromMm((least + most) / 2)}}});
}

}  // namespace caltwin

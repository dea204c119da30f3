#pragma once

#include "sim/measure/plan_options.h"

/// Options of campaigns on a delta.
namespace caltwin::plan_options {

inline constexpr PlanOption kDiscRadius = Number(
    "radius_mm",
    "0",
    {0, 2000},
    "How far out the outermost point lies [mm]; 0: the machine's print_radius_mm.");
inline constexpr std::array kDeltaGrid = {
    Count("points",
          "37",
          {7, 10'000},
          "Touches of the bed, spread evenly over the disc."),
    kRepeats,
    kDiscRadius,
    kFeeds,
    kName,
    kInstrument,
    kPause};
inline constexpr std::array kDeltaXy = {
    Count("points",
          "6",
          {3, 100},
          "Marks along each side of a square plate, read along x and y."),
    Numbers("heights_mm",
            "[2]",
            {0, 2000},
            "Of the plate over the bed, one laying after the other [mm]."),
    kDiscRadius,
    kName,
    kInstrument,
    kPause};
inline constexpr std::array kZColumns = {
    Count("places",
          "7",
          {1, 100},
          "Where a height gauge stands: the middle, the others on a circle."),
    Count("heights",
          "8",
          {2, 1000},
          "Heights at each place, each from above and from below."),
    Number(
        "to_mm", "0", {0, 2000}, "The highest [mm]; 0: as high as the disc is wide."),
    kDiscRadius,
    kName,
    kInstrument,
    kPause};

}  // namespace caltwin::plan_options

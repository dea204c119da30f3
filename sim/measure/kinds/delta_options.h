#pragma once

#include "sim/measure/plan_options.h"

/// Options of campaigns on a delta.
namespace caltwin::plan_options {

inline constexpr PlanOption kDiscRadius = {
    .name = "radius_mm",
    .otherwise = "0",
    .doc =
        "How far out the outermost point lies [mm]; 0: the machine's print_radius_mm.",
    .bounds = {0, 2000}};
inline constexpr std::array kDeltaGrid = {
    PlanOption{.name = "points",
               .type = kCount,
               .otherwise = "37",
               .doc = "Touches of the bed, spread evenly over the disc.",
               .bounds = {7, 10'000}},
    kRepeats,
    kDiscRadius,
    kFeeds,
    kName,
    kInstrument,
    kPause};
inline constexpr std::array kDeltaXy = {
    PlanOption{.name = "points",
               .type = kCount,
               .otherwise = "6",
               .doc = "Marks along each side of a square plate, read along x and y.",
               .bounds = {3, 100}},
    PlanOption{.name = "heights_mm",
               .type = kNumbers,
               .otherwise = "[2]",
               .doc = "Of the plate over the bed, one laying after the other [mm].",
               .bounds = {0, 2000}},
    kDiscRadius,
    kName,
    kInstrument,
    kPause};
inline constexpr std::array kZColumns = {
    PlanOption{
        .name = "places",
        .type = kCount,
        .otherwise = "7",
        .doc = "Where a height gauge stands: the middle, the others on a circle.",
        .bounds = {1, 100}},
    PlanOption{.name = "heights",
               .type = kCount,
               .otherwise = "8",
               .doc = "Heights at each place, each from above and from below.",
               .bounds = {2, 1000}},
    PlanOption{.name = "to_mm",
               .otherwise = "0",
               .doc = "The highest [mm]; 0: as high as the disc is wide.",
               .bounds = {0, 2000}},
    kDiscRadius,
    kName,
    kInstrument,
    kPause};

}  // namespace caltwin::plan_options

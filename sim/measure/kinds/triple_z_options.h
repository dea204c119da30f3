#pragma once

#include "sim/measure/plan_options.h"

/// Options of campaigns on a triple-Z printer.
namespace caltwin::plan_options {

inline constexpr PlanOption kTzMargin =
    Number("margin_mm", "15", {0, 1e4}, "Left free at the ends of x and y [mm].");
inline constexpr PlanOption kBedFeeds =
    Numbers("feeds_mm_s",
            "[5]",
            {0.01, 50},
            "Feeds at which the bed rises to the nozzle [mm/s]; three show a trigger "
            "latency.");
inline constexpr PlanOption kHeights =
    Count("heights",
          "12",
          {2, 1000},
          "Heights at each place, each from above and from below, at odd parts of a "
          "screw's turn.");
inline constexpr PlanOption kToHeight = Number(
    "to_mm",
    "0",
    {0, 2000},
    "The greatest height of the nozzle over the bed [mm]; 0: nearly the travel.");
inline constexpr std::array kTzGrid = {
    Numbers("grid", "[5, 5]", {2, 200}, "Points along x and y."),
    kRepeats,
    Numbers("probe_offset_mm",
            "[0]",
            {-500, 500},
            "Offsets of the tip along y with which all is touched [mm]; two "
            "show a twist of the beam."),
    kBedFeeds,
    kTzMargin,
    kName,
    kInstrument,
    kPause};
inline constexpr std::array kTzHeights = {
    Numbers("grid", "[3, 3]", {2, 200}, "Places along x and y."),
    kHeights,
    kToHeight,
    kTzMargin,
    kName,
    kInstrument,
    kPause};
inline constexpr std::array kFixedPost = {
    kHeights, kToHeight, kName, kInstrument, kPause};
inline constexpr std::array kScrewsOneByOne = {
    Number("travel_mm",
           "1",
           {0.01, 10},
           "How far each screw is moved up, and down, alone [mm]."),
    Numbers("grid",
            "[3, 3]",
            {2, 200},
            "Points along x and y, touched at every stand of the screws."),
    kBedFeeds,
    kTzMargin,
    kName,
    kInstrument,
    kPause};

}  // namespace caltwin::plan_options

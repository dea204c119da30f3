#pragma once

#include "sim/measure/plan_options.h"

/// Options of campaigns on a triple-Z printer.
namespace caltwin::plan_options {

inline constexpr PlanOption kTzMargin = {
    .name = "margin_mm",
    .otherwise = "15",
    .doc = "Left free at the ends of x and y [mm].",
    .bounds = {0, 1e4}};
inline constexpr PlanOption kBedFeeds = {
    .name = "feeds_mm_s",
    .type = kNumbers,
    .otherwise = "[5]",
    .doc =
        "Feeds at which the bed rises to the nozzle [mm/s]; three show a trigger "
        "latency.",
    .bounds = {0.01, 50}};
inline constexpr PlanOption kHeights = {
    .name = "heights",
    .type = kCount,
    .otherwise = "12",
    .doc =
        "Heights at each place, each from above and from below, at odd parts of a "
        "screw's turn.",
    .bounds = {2, 1000}};
inline constexpr PlanOption kToHeight = {
    .name = "to_mm",
    .otherwise = "0",
    .doc = "The greatest height of the nozzle over the bed [mm]; 0: nearly the travel.",
    .bounds = {0, 2000}};
inline constexpr std::array kTzGrid = {
    PlanOption{.name = "grid",
               .type = kNumbers,
               .otherwise = "[5, 5]",
               .doc = "Points along x and y.",
               .bounds = {2, 200}},
    kRepeats,
    PlanOption{.name = "probe_offset_mm",
               .type = kNumbers,
               .otherwise = "[0]",
               .doc = "Offsets of the tip along y with which all is touched [mm]; two "
                      "show a twist of the beam.",
               .bounds = {-500, 500}},
    kBedFeeds,
    kTzMargin,
    kName,
    kInstrument,
    kPause};
inline constexpr std::array kTzHeights = {PlanOption{.name = "grid",
                                                     .type = kNumbers,
                                                     .otherwise = "[3, 3]",
                                                     .doc = "Places along x and y.",
                                                     .bounds = {2, 200}},
                                          kHeights,
                                          kToHeight,
                                          kTzMargin,
                                          kName,
                                          kInstrument,
                                          kPause};
inline constexpr std::array kFixedPost = {
    kHeights, kToHeight, kName, kInstrument, kPause};
inline constexpr std::array kScrewsOneByOne = {
    PlanOption{.name = "travel_mm",
               .otherwise = "1",
               .doc = "How far each screw is moved up, and down, alone [mm].",
               .bounds = {0.01, 10}},
    PlanOption{.name = "grid",
               .type = kNumbers,
               .otherwise = "[3, 3]",
               .doc = "Points along x and y, touched at every stand of the screws.",
               .bounds = {2, 200}},
    kBedFeeds,
    kTzMargin,
    kName,
    kInstrument,
    kPause};

}  // namespace caltwin::plan_options

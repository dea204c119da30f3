#pragma once

#include "sim/measure/plan_options.h"

/// Options of campaigns touched by the machine's own probe.
namespace caltwin::plan_options {

inline constexpr std::array kStraightedge = {
    kAxis,
    Word("across",
         "y",
         kAxisWords,
         "Direction in which the edge is touched; must be another axis "
         "(the other of x and y where it is the same)."),
    Count("positions", "15", {3, 10'000}, "Places along the edge."),
    Count("repeats", "3", {1, 1000}, "How often each place is touched on each side."),
    Number("width_mm",
           "20",
           {1, 500},
           "Of the straight-edge, between the sides touched [mm]."),
    Number("height_mm", "15", {0, 1e4}, "Of the touches above the table [mm]."),
    kFeeds,
    kMargin,
    kArtefact,
    kName,
    kInstrument,
    kPause};
inline constexpr std::array kSquare = {
    Word("plane",
         "xy",
         kPlaneWords,
         "xy: a square lying flat, both outer edges; xz, yz: a blade "
         "standing up."),
    Number("leg_mm", "180", {10, 5000}, "Length of its legs [mm]."),
    Count("points", "10", {2, 1000}, "Touches along each leg."),
    kRepeats,
    Numbers("turns_deg",
            "[]",
            {-360, 360},
            "How the square lies, one after the other [deg]; empty: 0 and 90 "
            "flat, 0 and 180 standing. Two separate its own error from the "
            "machine's."),
    kFeeds,
    kArtefact,
    kName,
    kInstrument,
    kPause};
inline constexpr std::array kBlocks = {
    Numbers("size_mm",
            "[76.2, 50.8, 25.4]",
            {1, 1000},
            "Of the block [mm], long to short."),
    Count(
        "ways", "3", {1, 3}, "Ways in which it is laid: long side along x, y, then z."),
    Count("points", "3", {1, 1000}, "Touches on each of its five free faces."),
    Numbers("second_mm",
            "[]",
            {1, 1000},
            "Sizes of a second block [mm]: tells a wrong block from a wrong "
            "scale."),
    Numbers(
        "feeds_mm_s", "[1, 5]", {0.01, 50}, "Feeds of the touch that counts [mm/s]."),
    kSpindle,
    kArtefact,
    kName,
    kInstrument,
    kPause};
inline constexpr std::array kPlate = {
    Numbers("grid", "[7, 7]", {2, 200}, "Points along x and y."),
    kRepeats,
    Numbers("probe_offset_mm",
            "[0]",
            {-500, 500},
            "Offsets of the tip along y with which all is touched [mm]; two "
            "show a twist of the beam."),
    Numbers("extent_mm",
            "[]",
            {1, 1e4},
            "Of the grid along x and y [mm]; empty: the travel less margins."),
    Number("height_mm",
           "0",
           {0, 1e4},
           "Of the plate's top above the machine's origin [mm]."),
    kFeeds,
    kMargin,
    kArtefact,
    kName,
    kInstrument,
    kPause};
inline constexpr std::array kRing = {
    Number("diameter_mm", "50", {5, 1000}, "Of the bore, by its certificate [mm]."),
    Count("points", "24", {3, 1000}, "Touches around the bore."),
    Numbers("spindle_deg",
            "[0, 90, 180, 270]",
            {-360, 360},
            "Spindle orientations, counter-clockwise from above [deg]."),
    Count("repeats", "1", {1, 1000}, "How often each point is touched."),
    Number("height_mm", "10", {0, 1e4}, "Of the touches above the table [mm]."),
    kFeeds,
    kAt,
    kArtefact,
    kName,
    kInstrument,
    kPause};
inline constexpr std::array kAlternating = {
    kAxis,
    Count("pairs", "40", {2, 10'000}, "How often both faces are touched."),
    Number("interval_s", "80", {1, 1e5}, "From pair to pair [s]."),
    Flag("from_cold",
         "true",
         "The spindle is switched on at its start, and off after half."),
    kFeeds,
    kArtefact,
    kName,
    kInstrument,
    kPause};
inline constexpr std::array kRehoming = {
    Count("homings", "16", {2, 1000}, "How often the machine is referenced."),
    Count("repeats", "2", {1, 100}, "Touches of each face after each homing."),
    kFeeds,
    kArtefact,
    kName,
    kInstrument,
    kPause};
inline constexpr std::array kDrift = {
    Word("axis", "x", kLevelWords, "Along which two posts stand far apart."),
    Number("duration_s", "14400", {60, 1e6}, "Warm-up and cool-down together [s]."),
    Number("interval_s", "400", {10, 1e5}, "From round to round [s]."),
    Flag("from_cold",
         "true",
         "Spindle and bed heater are switched on at its start (the bed's "
         "later) and off halfway; else the machine stays as warm as it "
         "is."),
    Number("warm_up_k",
           "10",
           {-50, 100},
           "By how much the screws would warm in the end [K]; the frame by "
           "0.4, the bed by 0.6 of it."),
    kFeeds,
    kArtefact,
    kName,
    kInstrument,
    kPause};

}  // namespace caltwin::plan_options

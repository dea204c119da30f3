#pragma once

#include "sim/measure/plan_options.h"

/// Options of campaigns read by a gauge.
namespace caltwin::plan_options {

inline constexpr std::array kIso230 = {
    kAxis,
    kPositions,
    Count("runs", "5", {1, 1000}, "There and back, so often."),
    kRegular,
    kDwell,
    kMargin,
    kAt,
    Numbers("loads_n",
            "[]",
            {0, 1e4},
            "Axial loads under which all runs are made [N]; two show wind-up. "
            "Empty: the rail's own friction."),
    kName,
    kInstrument,
    kPause};
inline constexpr std::array kDense = {
    kAxis,
    Number("periods", "2.5", {0.5, 100}, "Length in turns of the screw or pulley."),
    Count("points_per_period",
          "24",
          {3, 1000},
          "Readings a turn, in a step that fits no period."),
    Numbers("start_mm",
            "[]",
            {-1e5, 1e5},
            "Where it starts [mm]; empty: a place of chance."),
    Count("runs",
          "1",
          {1, 1000},
          "There and back, so often; the turn is read as it comes."),
    kDwell,
    kMargin,
    kAt,
    kName,
    kInstrument,
    kPause};
inline constexpr std::array kAbbe = {
    kAxis,
    Word("lever",
         "z",
         kAxisWords,
         "The axis at whose places the line is measured again."),
    Numbers("heights_mm",
            "[]",
            {-1e5, 1e5},
            "Places of the lever axis [mm]; empty: 10 % from both ends."),
    Count("positions", "15", {2, 10'000}, "Targets along the axis."),
    Count("runs", "2", {1, 1000}, "There and back at each height, so often."),
    kRegular,
    kDwell,
    kMargin,
    kAt,
    kName,
    kInstrument,
    kPause};
inline constexpr std::array kBallbar = {
    Number("radius_mm", "100", {5, 2000}, "Length of the bar [mm]."),
    Count("points", "40", {8, 10'000}, "Readings a turn."),
    Numbers("feeds_mm_s",
            "[15, 60]",
            {0.1, 1000},
            "Feeds along the circle [mm/s]; two show servo errors."),
    Numbers("senses",
            "[1, -1]",
            {-1, 1},
            "+1: counter-clockwise from above, -1: clockwise."),
    Count("runs", "1", {1, 100}, "Turns read at each feed and sense."),
    kAt,
    kName,
    kInstrument,
    kPause};

}  // namespace caltwin::plan_options

#pragma once

#include "sim/measure/plan_options.h"

/// Options of campaigns on a CoreXY.
namespace caltwin::plan_options {

inline constexpr std::array kDiagonals = {
    kPositions,
    Count("runs", "3", {1, 1000}, "There and back along each diagonal, so often."),
    Flag("across",
         "false",
         "Whether it is read across the diagonal too, as a tracker does."),
    kDwell,
    kMargin,
    kName,
    kInstrument,
    kPause};

}  // namespace caltwin::plan_options

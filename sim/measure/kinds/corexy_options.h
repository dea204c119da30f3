#pragma once

#include "sim/measure/plan_options.h"

/// Options of campaigns on a CoreXY.
namespace caltwin::plan_options {

inline constexpr std::array kDiagonals = {
    kPositions,
    PlanOption{.name = "runs",
               .type = kCount,
               .otherwise = "3",
               .doc = "There and back along each diagonal, so often.",
               .bounds = {1, 1000}},
    PlanOption{.name = "across",
               .type = kFlag,
               .otherwise = "false",
               .doc = "Whether it is read across the diagonal too, as a tracker does."},
    kDwell,
    kMargin,
    kName,
    kInstrument,
    kPause};

}  // namespace caltwin::plan_options

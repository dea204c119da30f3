#pragma once

#include "sim/measure/plan_options.h"

/// Options of campaigns at a printer's station of nozzle, switch and probe.
namespace caltwin::plan_options {

inline constexpr Bounds kHeaterBounds = {0, 400};
inline constexpr PlanOption kRounds = {
    .name = "rounds",
    .type = kCount,
    .otherwise = "24",
    .doc =
        "Rounds, each with one choice of the temperatures; the choices come in an "
        "order of chance, again from the first once all were there.",
    .bounds = {1, 10'000}};
inline constexpr PlanOption kNozzleTemps = {.name = "nozzle_c",
                                            .type = kNumbers,
                                            .otherwise = "[25, 120, 180, 240]",
                                            .doc = "Nozzle temperatures [degC].",
                                            .bounds = kHeaterBounds};
inline constexpr PlanOption kBedTemps = {.name = "bed_c",
                                         .type = kNumbers,
                                         .otherwise = "[25, 60, 100]",
                                         .doc = "Bed temperatures [degC].",
                                         .bounds = kHeaterBounds};
inline constexpr PlanOption kChamberTemps = {.name = "chamber_c",
                                             .type = kNumbers,
                                             .otherwise = "[25, 50]",
                                             .doc = "Chamber temperatures [degC].",
                                             .bounds = kHeaterBounds};
inline constexpr PlanOption kSoak = {
    .name = "soak_s",
    .otherwise = "600",
    .doc = "Time at the temperatures before anything is touched [s].",
    .bounds = {0, 1e5}};
inline constexpr PlanOption kWiped = {
    .name = "wiped",
    .type = kFlag,
    .otherwise = "false",
    .doc = "Whether somebody wipes the nozzle before each round: no ooze then."};
inline constexpr std::array kZOffset = {
    kRounds,
    kNozzleTemps,
    kBedTemps,
    kChamberTemps,
    kSoak,
    kWiped,
    PlanOption{.name = "repeats",
               .type = kCount,
               .otherwise = "3",
               .doc = "How often each of the three is touched in a round.",
               .bounds = {1, 1000}},
    PlanOption{.name = "feed_mm_s",
               .otherwise = "5",
               .doc = "Feed of the touches [mm/s].",
               .bounds = {0.01, 50}},
    PlanOption{.name = "homes",
               .type = kFlag,
               .otherwise = "true",
               .doc = "Whether Z is homed at the beginning of each round; else once."},
    kName,
    kInstrument,
    kPause};
inline constexpr std::array kZGap = {
    PlanOption{.name = "rounds",
               .type = kCount,
               .otherwise = "8",
               .doc = "Rounds, each with one choice of the temperatures.",
               .bounds = {1, 10'000}},
    kNozzleTemps,
    PlanOption{.name = "bed_c",
               .type = kNumbers,
               .otherwise = "[25]",
               .doc = "Bed temperatures [degC].",
               .bounds = kHeaterBounds},
    kChamberTemps,
    kSoak,
    kWiped,
    PlanOption{.name = "heights_mm",
               .type = kNumbers,
               .otherwise = "[1, 0.5, 0.3]",
               .doc = "Commanded heights at which the gap is measured [mm].",
               .bounds = {0.02, 20}},
    kName,
    kInstrument,
    kPause};

}  // namespace caltwin::plan_options

#pragma once

#include "sim/measure/plan_options.h"

/// Options of campaigns at a printer's station of nozzle, switch and probe.
namespace caltwin::plan_options {

inline constexpr Bounds kHeaterBounds = {0, 400};
inline constexpr PlanOption kRounds =
    Count("rounds",
          "24",
          {1, 10'000},
          "Rounds, each with one choice of the temperatures; the choices come in an "
          "order of chance, again from the first once all were there.");
inline constexpr PlanOption kNozzleTemps = Numbers(
    "nozzle_c", "[25, 120, 180, 240]", kHeaterBounds, "Nozzle temperatures [degC].");
inline constexpr PlanOption kBedTemps =
    Numbers("bed_c", "[25, 60, 100]", kHeaterBounds, "Bed temperatures [degC].");
inline constexpr PlanOption kChamberTemps =
    Numbers("chamber_c", "[25, 50]", kHeaterBounds, "Chamber temperatures [degC].");
inline constexpr PlanOption kSoak =
    Number("soak_s",
           "600",
           {0, 1e5},
           "Time at the temperatures before anything is touched [s].");
inline constexpr PlanOption kWiped =
    Flag("wiped",
         "false",
         "Whether somebody wipes the nozzle before each round: no ooze then.");
inline constexpr std::array kZOffset = {
    kRounds,
    kNozzleTemps,
    kBedTemps,
    kChamberTemps,
    kSoak,
    kWiped,
    Count("repeats",
          "3",
          {1, 1000},
          "How often each of the three is touched in a round."),
    Number("feed_mm_s", "5", {0.01, 50}, "Feed of the touches [mm/s]."),
    Flag("homes",
         "true",
         "Whether Z is homed at the beginning of each round; else once."),
    kName,
    kInstrument,
    kPause};
inline constexpr std::array kZGap = {
    Count("rounds",
          "8",
          {1, 10'000},
          "Rounds, each with one choice of the temperatures."),
    kNozzleTemps,
    Numbers("bed_c", "[25]", kHeaterBounds, "Bed temperatures [degC]."),
    kChamberTemps,
    kSoak,
    kWiped,
    Numbers("heights_mm",
            "[1, 0.5, 0.3]",
            {0.02, 20},
            "Commanded heights at which the gap is measured [mm]."),
    kName,
    kInstrument,
    kPause};

}  // namespace caltwin::plan_options

#pragma once

#include <vector>

#include "calibration/facts/repeats.h"

namespace caltwin {

/// What two groups of rows say against each other: two sides measured at once, two
/// gauges over the same places, one place come upon in two ways, several switches, two
/// programs. `rows` in the order measured.
void FactsOfGroups(const std::vector<const Row*>& rows,
                   const Repeats& repeats,
                   const DataHeader& header,
                   Facts* facts);

/// What moves under several steps/mm say: what the axis needs, that the trials
/// contradict each other, or that the steps/mm are those of freshly written firmware.
void FactsOfTrials(const std::vector<const Row*>& rows,
                   const DataHeader& header,
                   Facts* facts);

/// What two instruments (as the header has them) say of one axis over the same places:
/// whether one reads a longer way, or more at a reversal, and which of the two errs
/// where their certificates tell.
void FactsOfInstruments(const std::vector<const Row*>& rows,
                        const Repeats& repeats,
                        const DataHeader& header,
                        Facts* facts);

/// What depends on what went before a reading: a change of axis, a stop. No mechanics
/// do that.
void FactsOfHistory(const std::vector<const Row*>& rows, Facts* facts);

}  // namespace caltwin

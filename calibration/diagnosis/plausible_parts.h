#pragma once

#include <vector>

#include "calibration/diagnosis/plausible.h"
#include "calibration/diagnosis/row_series.h"

namespace caltwin {

/// @name The parts of Doubts(), each adding to `doubts` what it finds.
/// @{

/// Rows one by one and in their order: finite, enough, not twice, times, temperatures,
/// steps, senses.
void DoubtRows(const RowTable& table, std::vector<Doubt>* doubts);

/// Sizes against each other and against what a machine can do: units, signs, positions
/// in place of deviations, stated sigmas.
void DoubtSizes(const RowTable& table,
                const DataHeader& header,
                std::vector<Doubt>* doubts);

/// Commands against the travel since the last reversal, in the order measured.
void DoubtMoves(const std::vector<const Row*>& rows, std::vector<Doubt>* doubts);

/// The gap of an axis in one campaign against another's.
void DoubtGaps(const std::vector<RowSeries>& all, std::vector<Doubt>* doubts);

/// Positions against the travel of the axes.
void DoubtTravel(const RowTable& table,
                 const Machine& machine,
                 std::vector<Doubt>* doubts);

/// @}

}  // namespace caltwin

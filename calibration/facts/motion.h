#pragma once

#include <vector>

#include "calibration/facts/repeats.h"

namespace caltwin {

/// What positions and touches say of motion, each axis by itself: moved over commanded
/// (and whether that ratio is one that people know), lost motion at reversal, readings
/// that depend on the sense of another axis, latency of a trigger.
void FactsOfMotion(const std::vector<const Row*>& rows,
                   const Repeats& repeats,
                   const DataHeader& header,
                   Facts* facts);

/// What lengths along several directions in one plane say: the skew of its axes, where
/// diagonals are among them.
void FactsOfLengths(const std::vector<const Row*>& rows,
                    const DataHeader& header,
                    Facts* facts);

/// Touches of one face at several feeds: value = a - latency v.
void FactsOfLatency(const std::vector<const Row*>& rows,
                    const Repeats& repeats,
                    Facts* facts);

}  // namespace caltwin

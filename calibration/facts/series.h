#pragma once

#include <vector>

#include "calibration/facts/repeats.h"

namespace caltwin {

/// What rows of several places say in the order they were touched, and of one series
/// against another: heights that run away with every touch, wherever it is; two maps of
/// the same places that differ by a constant.
void FactsOfSeries(const std::vector<const Row*>& rows,
                   const Repeats& repeats,
                   Facts* facts);

/// What readings of one thing say that a person or program set: a zero that is off by a
/// constant, tools of different length, walls outside and inside, a correction that
/// doubles what it should remove, sizes that no scale explains, a constant added at
/// every homing.
void FactsOfSetting(const std::vector<const Row*>& rows, Facts* facts);

/// What a probe's offset found by paper at several places says: that it is not one
/// number; along X alone and in a straight line, with the probe beside the nozzle along
/// Y, a twist of the X axis.
void FactsOfProbeOffset(const std::vector<const Row*>& rows, Facts* facts);

/// Where bad touches are high in the air while all others repeat: the probe triggers by
/// itself, and it is not the machine.
void TellBadProbe(const std::vector<const Row*>& rows,
                  const Repeats& repeats,
                  Facts* facts);

}  // namespace caltwin

#pragma once

#include <string>
#include <vector>

#include "sim/effects/effect.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// A controller takes no more points of a screw (LinuxCNC, EMCMOT_COMP_SIZE).
inline constexpr int kMostScrewTablePoints = 256;

/// Behind the name that the user gave, of the screw table of an axis: ".x.comp".
std::string ScrewTableSuffix(Axis axis);

/// As many points as the shortest wave of these effects needs; 0 where that is more
/// than are allowed.
int ScrewTablePoints(const Machine& machine,
                     Axis axis,
                     const std::vector<Injected>& effects);

/// LinuxCNC's table, a line a point: nominal, actual forwards and backwards [mm]. Such
/// a table ends at the first line that is not three numbers, so it has no comments.
std::string ScrewTableText(const Machine& machine,
                           Axis axis,
                           const std::vector<Injected>& effects,
                           double gap_mm);

}  // namespace caltwin

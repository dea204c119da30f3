#pragma once

#include <array>
#include <optional>

#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// Full width of the gap between each carriage and its drive [mm]; 0: none.
using CarriageGaps_mm = std::array<double, 3>;

bool HasPlay(const CarriageGaps_mm& gaps_mm);

/// A build at rest with its play taken up, every motor having come to its commanded
/// travel in its sense (+1: down, -1: up, 0: the middle of the gap): each loose
/// carriage stands off the middle of its gap, which is what an endstop does.
///
///   endstop_i += dir_i gap_i / 2   where its rail holds it
///   endstop_i -= gap_i / 2         where it hangs, whichever way it came
///   hangs: TowerLoad_n not below rail_friction_n
///
/// Which of the two, the pose without play decides: gaps change the load by less than
/// a thousandth. nullopt: the chain does not close.
std::optional<DeltaBuild<double>> WithPlayTaken(const DeltaBuild<double>& build,
                                                const Machine& machine,
                                                const CarriageGaps_mm& gaps_mm,
                                                const Vec3<double>& motors_mm,
                                                const Vec3<double>& motor_dir);

}  // namespace caltwin

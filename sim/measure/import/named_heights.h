#pragma once

#include <string>

#include "sim/measure/import/import.h"

namespace caltwin {

/// Whether a text holds heights whose places are told by name alone: of a delta its
/// centre, towers and the places across from them ("c: 0.002 x: ... ox: ...", of Marlin
/// "yz", "zx", "xy"), or corners of a bed ("FrontR 0.065", "back left: 0.35").
bool HasNamedHeights(const std::string& text);

/// Reads them: touches of features "delta.c", "delta.x", "delta.ox" at a circle of
/// radius 1, or of "corner.front_left" ... at a square of side 1. The places are of use
/// among themselves only. Each run of corners is a campaign, named after the line
/// before it. Throws InputError where nothing of the sort stands there.
Imported ReadNamedHeights(const std::string& text,
                          const std::string& name,
                          const ImportOptions& options);

}  // namespace caltwin

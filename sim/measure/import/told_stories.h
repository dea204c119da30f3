#pragma once

#include <optional>
#include <string>

#include "sim/measure/import/import.h"

namespace caltwin {

/// What a text of results or remarks tells that is no table of readings; each is
/// nullopt where the text is nothing of the kind. `recognised` says what it was taken
/// for. None of them holds rows: numbers that a firmware fitted are no readings.
///
/// Runs of a probe's correction over temperature, `index, temp, ustep, um`: what of
/// them differs from run to run, one constant or the shape.
std::optional<Imported> TemperatureTablesIn(const std::string& text);

/// A firmware's own fit of many parameters, `RMS error after iteration 2: 0.41 mm`,
/// that ends far above what a probe scatters.
std::optional<Imported> StalledFitIn(const std::string& text);

/// Sizes that a calibration found run by run, `Frame size: 2668 x 1579 mm`, far apart.
std::optional<Imported> SizesByRunIn(const std::string& text);

/// Speeds of a screw under several pulses a turn, beside the speed that it should have.
std::optional<Imported> SpeedsByPulsesIn(const std::string& text);

/// What the two motors of one axis moved: "Y1 moves 100 cm", "Y2 moves 99.5 cm".
std::optional<Imported> TwoSidesIn(const std::string& text);

/// Corrections of a delta's rods beside the rods as measured.
std::optional<Imported> RodTrimsIn(const std::string& text);

/// Widths of parts of an object and distances over them: what the machine moved, and
/// how wide the line is laid down.
std::optional<Imported> WidthsAndDistancesIn(const std::string& text);

/// Moves that are too long by a share up to some height, and by a constant above it: a
/// correction that fades.
std::optional<Imported> FadedConstantIn(const std::string& text);

/// Two runs over the same positions, there and back, of something that has its least at
/// the best position (the size of stars): the two leasts lie a lost motion apart.
std::optional<Imported> LeastThereAndBackIn(const std::string& text);

/// What each of them begins with: what the text was taken for, what it leaves open, and
/// what to measure next.
Imported ToldOf(std::string recognised,
                std::string open,
                std::string instrument,
                std::string next);

/// The first of them all that a text is.
std::optional<Imported> ToldStoryIn(const std::string& text);

}  // namespace caltwin

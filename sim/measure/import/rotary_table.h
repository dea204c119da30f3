#pragma once

#include <optional>
#include <string>

#include "sim/measure/import/import.h"

namespace caltwin {

/// What a table of a rotary axis says, angles it was told beside how far it is off,
/// both in degrees:
///
///   off = k angle,   steps per degree are off by the same fraction k
///
/// An error that grows with the turns and goes back with them is no lost step. grbl
/// writes its steps per degree ($103) with three decimals, which alone is up to
/// 0.0005 / $103. Nullopt: the text has no such table, or its errors do not grow.
std::optional<FileNote> NoteOfRotaryTable(const std::string& text);

/// The same as a file without readings along x, y and z. Throws InputError where it is
/// nullopt.
Imported ReadRotaryTable(const std::string& text,
                         const std::string& name,
                         const ImportOptions& options);

}  // namespace caltwin

#pragma once

#include <optional>
#include <string>

#include "sim/measure/import/import.h"

namespace caltwin {

/// Whether a program makes the size that was drawn, where a text holds its moves, the
/// tool's diameter, the size, and on which side of the line the tool goes:
///
///   made = extent of the path + tool   (inside; - outside)
///
/// A note of the program, or that it is right and the machine to be looked at; nullopt:
/// something of that does not stand there.
std::optional<FileNote> NoteOfDrawnPath(const std::string& text);

/// The same as a file without readings. Throws InputError where it is nullopt.
Imported ReadDrawnPath(const std::string& text,
                       const std::string& name,
                       const ImportOptions& options);

}  // namespace caltwin

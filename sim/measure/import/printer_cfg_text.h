#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "sim/base/input_error.h"

namespace caltwin {

/// Its lines with their indentation, which says that a value goes on; no ends of lines.
std::vector<std::string_view> RawLines(std::string_view config);

/// The printer.cfg with further lines, before what SAVE_CONFIG has written at its end.
std::string WithAdded(const std::string& config, std::string_view lines);

/// The same with what its `[include FILE]` name in their place, each file once, as a
/// host reads it: paths are relative to the file that names them, `*` and `?` stand for
/// letters. What names nothing but folders and files of more than a megabyte stays.
std::string WithIncluded(const std::string& config,
                         const std::filesystem::path& folder);

/// Where what a host complains of stands: "Option 'x' is not valid in section 'y'",
/// "Section 'y' ...". Without a line where it is not to be found.
Place PlaceOfComplaint(const std::string& says,
                       const std::string& config,
                       const std::string& name);

}  // namespace caltwin

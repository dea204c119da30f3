#pragma once

#include <filesystem>
#include <string>

namespace blind {

/// Writes the text; throws std::runtime_error where it cannot.
void WriteText(const std::filesystem::path& file, const std::string& text);

}  // namespace blind

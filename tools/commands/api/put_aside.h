#pragma once

#include <filesystem>
#include <string>

namespace caltwin {

/// Renames a file that this version did not write to FILE.unread, so that nothing is
/// lost, and says so.
std::string PutAside(const std::filesystem::path& file);

}  // namespace caltwin

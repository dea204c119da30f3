#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace caltwin {

/// Names and texts of LinuxCNC's configuration, the INI file first.
using LinuxCncFiles = std::vector<std::pair<std::string, std::string>>;

/// A user's INI file and what lies beside it, which it may name: plain files up to a
/// megabyte. Throws InputError.
LinuxCncFiles FilesBesideIni(const std::filesystem::path& ini);

/// `ini` with `setting`, SECTION.KEY=VALUE. Throws InputError at `place` where it is
/// none.
std::string WithIniSetting(const std::string& ini,
                           const std::string& setting,
                           const std::string& place);

}  // namespace caltwin

#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace caltwin {

/// Names and texts of LinuxCNC's configuration, the INI file first.
using LinuxCncFiles = std::vector<std::pair<std::string, std::string>>;

/// A user's INI file and what lies beside it and in folders there, which it may name:
/// plain files up to a megabyte. Throws InputError where it is no INI file of
/// LinuxCNC's, or where that is very much.
LinuxCncFiles FilesBesideIni(const std::filesystem::path& ini);

/// Subroutines beside a program: the other .ngc files of its folder.
LinuxCncFiles SubroutinesBeside(const std::filesystem::path& program);

/// Throws InputError at `place` where the line is longer than LinuxCNC's MDI takes.
void RequireMdiLine(std::string_view line, const std::string& place);

/// `ini` with `setting`, SECTION.KEY=VALUE. Throws InputError at `place` where it is
/// none, where the file has no such section, where a key that it does have is nearly
/// the same, or where it includes others, in which the value may stand.
std::string WithIniSetting(const std::string& ini,
                           const std::string& setting,
                           const std::string& place);

}  // namespace caltwin

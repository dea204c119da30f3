#pragma once

#include <filesystem>
#include <string_view>

namespace caltwin {

/// The folder of the program that runs.
std::filesystem::path ProgramFolder();

/// A library that caltwin loads into others: beside the program that was built (a test
/// is one folder down), or where it was installed to. Throws InputError.
std::filesystem::path FileBesideProgram(std::string_view name);

}  // namespace caltwin

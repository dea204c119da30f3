#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace caltwin {

/// What a file is for, told by its top-level keys (or by the ending .csv).
enum class FileKind {
  kScenario,    ///< calibrate
  kStudy,       ///< study
  kPlan,        ///< campaigns, a list
  kMachine,     ///< kinematics or extends
  kDataHeader,  ///< campaigns as a map, artefacts, transmission, a .csv of that name
  kTruth,       ///< effects or settings alone
  kData         ///< .csv
};
std::string ToString(FileKind kind);

/// Throws InputError where the file cannot be read or tells no kind.
FileKind KindOf(const std::filesystem::path& file);

/// The scenarios among files and folders: a file stands for itself, a folder for the
/// scenarios in it (not below it), by name. Throws InputError for a path that is not
/// there and a folder without scenarios.
std::vector<std::filesystem::path> FindScenarios(
    const std::vector<std::string>& files_or_folders);

}  // namespace caltwin

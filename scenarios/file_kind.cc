#include "scenarios/file_kind.h"

#include <algorithm>
#include <system_error>

#include <fmt/format.h>

#include "sim/base/yaml.h"

namespace caltwin {

namespace fs = std::filesystem;

namespace {

bool IsScenario(const fs::path& file) {
  try {
    return KindOf(file) == FileKind::kScenario;
  } catch (const InputError&) {
    return true;  // Whoever reads it will say what is wrong with it.
  }
}

std::vector<fs::path> ScenariosIn(const fs::path& folder) {
  std::vector<fs::path> found;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().extension() == ".yaml" && entry.is_regular_file(error) &&
        IsScenario(entry.path())) {
      found.push_back(entry.path());
    }
  }
  if (found.empty()) {
    throw InputError({.file = folder.string()},
                     "this folder has no scenarios in it",
                     "a scenario is a .yaml file with the key 'calibrate'; folders "
                     "below are not searched");
  }
  std::ranges::sort(found);
  return found;
}

}  // namespace

std::string ToString(FileKind kind) {
  switch (kind) {
    case FileKind::kScenario:
      return "scenario";
    case FileKind::kStudy:
      return "study";
    case FileKind::kPlan:
      return "plan";
    case FileKind::kMachine:
      return "machine";
    case FileKind::kDataHeader:
      return "data header";
    case FileKind::kTruth:
      return "truth";
    case FileKind::kData:
      break;
  }
  return "data";
}

FileKind KindOf(const fs::path& file) {
  if (file.extension() == ".csv") return FileKind::kData;
  Faults faults;
  YamlMap map = ReadYamlFile(file, &faults);
  if (map.Has("study")) return FileKind::kStudy;
  if (map.Has("calibrate") || map.Has("controller")) return FileKind::kScenario;
  const auto campaigns = map.Optional("campaigns");
  if (campaigns && campaigns->is_list()) return FileKind::kPlan;
  if (map.Has("kinematics") || map.Has("extends")) return FileKind::kMachine;
  std::error_code error;
  const bool has_data = fs::exists(fs::path(file).replace_extension(".csv"), error);
  if (campaigns || map.Has("artefacts") || map.Has("transmission") || has_data) {
    return FileKind::kDataHeader;
  }
  if (map.Has("effects") || map.Has("settings")) return FileKind::kTruth;
  throw InputError(
      {.file = file.string()},
      "no key tells what this file is for",
      "a scenario has 'calibrate', a machine 'kinematics' or 'extends', a truth file "
      "'effects' or 'settings', a plan 'campaigns' as a list, a data header "
      "'campaigns', 'artefacts' or 'transmission', a study 'study'");
}

std::vector<fs::path> FindScenarios(const std::vector<std::string>& files_or_folders) {
  std::vector<fs::path> found;
  for (const std::string& name : files_or_folders) {
    std::error_code error;
    if (fs::is_directory(name, error)) {
      const auto inside = ScenariosIn(name);
      found.insert(found.end(), inside.begin(), inside.end());
    } else {
      found.emplace_back(name);
    }
  }
  return found;
}

}  // namespace caltwin

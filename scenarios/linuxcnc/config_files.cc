#include "scenarios/linuxcnc/config_files.h"

#include <algorithm>

#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "sim/base/text_file.h"
#include "sim/controllers/linuxcnc/config.h"

namespace caltwin {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void RefuseName(const std::string& place,
                             const std::string& what,
                             const std::string& name,
                             const std::vector<std::string>& known) {
  const std::string nearest = NearestWord(name, known);
  throw InputError({.file = place},
                   fmt::format("the INI file has no {} '{}'", what, name),
                   nearest.empty() ? "" : fmt::format("did you mean '{}'?", nearest));
}

void RequireKnown(const std::string& ini,
                  const std::string& section,
                  const std::string& key,
                  const std::string& place) {
  if (linuxcnc::IniIncludes(ini)) {
    throw InputError({.file = place},
                     "the INI file includes others, in which that value may stand",
                     "set it in the file itself");
  }
  const auto sections = linuxcnc::IniSections(ini);
  if (std::ranges::find(sections, section) == sections.end()) {
    RefuseName(place, "section", section, sections);
  }
  const auto keys = linuxcnc::IniKeys(ini, section);
  const bool is_there = std::ranges::find(keys, key) != keys.end();
  // A key may be new, as COMP_FILE; one that is nearly another is a slip.
  if (!is_there && !NearestWord(key, keys).empty()) {
    RefuseName(place, fmt::format("key in [{}]", section), key, keys);
  }
}

}  // namespace

LinuxCncFiles FilesBesideIni(const fs::path& ini) {
  constexpr std::size_t kMostFiles = 1000;
  LinuxCncFiles files = {
      {ini.filename().string(), ReadTextFile(ini, kLargestFile_bytes)}};
  const auto sections = linuxcnc::IniSections(files.front().second);
  if (std::ranges::find(sections, "EMC") == sections.end()) {
    throw InputError({.file = ini.string()},
                     "is no INI file of LinuxCNC: it has no section [EMC]",
                     "caltwin new linuxcnc MACHINE --out FOLDER writes one");
  }
  const fs::path folder = fs::absolute(ini).parent_path();
  constexpr auto kSkip = fs::directory_options::skip_permission_denied;
  for (const fs::directory_entry& entry :
       fs::recursive_directory_iterator(folder, kSkip)) {
    const bool is_one = entry.is_regular_file() &&
                        entry.file_size() <= kLargestFile_bytes &&
                        entry.path() != folder / ini.filename();
    if (!is_one) continue;
    if (files.size() > kMostFiles) {
      throw InputError({.file = folder.string()},
                       fmt::format("more than {} files lie beside the INI file, and "
                                   "all of them would go with it",
                                   kMostFiles),
                       "give it a folder of its own");
    }
    files.emplace_back(entry.path().lexically_relative(folder).string(),
                       ReadTextFile(entry.path(), kLargestFile_bytes));
  }
  return files;
}

LinuxCncFiles SubroutinesBeside(const fs::path& program) {
  LinuxCncFiles files;
  const fs::path folder = fs::absolute(program).parent_path();
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const bool is_one = entry.is_regular_file() && entry.path().extension() == ".ngc" &&
                        entry.file_size() <= kLargestFile_bytes &&
                        entry.path().filename() != program.filename();
    if (!is_one) continue;
    files.emplace_back(entry.path().filename().string(),
                       ReadTextFile(entry.path(), kLargestFile_bytes));
  }
  return files;
}

void RequireMdiLine(std::string_view line, const std::string& place) {
  constexpr std::size_t kLongest = 254;
  if (line.size() <= kLongest) return;
  throw InputError(
      {.file = place},
      fmt::format("has {} bytes; LinuxCNC takes {} at MDI", line.size(), kLongest),
      "put it into a program");
}

std::string WithIniSetting(const std::string& ini,
                           const std::string& setting,
                           const std::string& place) {
  const auto point = setting.find('.'), equals = setting.find('=');
  const bool is_one = equals != std::string::npos && point != std::string::npos &&
                      point > 0 && point + 1 < equals;
  if (!is_one) {
    throw InputError({.file = place},
                     "a section, a key and a value are wanted",
                     "as in JOINT_0.BACKLASH=0.05");
  }
  const std::string section = setting.substr(0, point);
  const std::string key = setting.substr(point + 1, equals - point - 1);
  RequireKnown(ini, section, key, place);
  return linuxcnc::WithIniValue(ini, section, key, setting.substr(equals + 1));
}

}  // namespace caltwin

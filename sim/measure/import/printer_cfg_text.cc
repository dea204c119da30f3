#include "sim/measure/import/printer_cfg_text.h"

#include <algorithm>
#include <regex>
#include <set>
#include <system_error>

#include <glob.h>

#include "sim/base/text_file.h"
#include "sim/measure/import/printer_cfg.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kSaved = "#*#", kInclude = "[include ";

// Empty: the line includes nothing.
std::string_view IncludedBy(std::string_view line) {
  if (!line.starts_with(kInclude)) return {};
  line.remove_prefix(kInclude.size());
  return line.substr(0, line.find(']'));
}

std::vector<fs::path> FilesNamed(std::string_view pattern, const fs::path& folder) {
  std::vector<fs::path> files;
  glob_t found{};
  if (glob((folder / pattern).c_str(), 0, nullptr, &found) == 0) {
    for (std::size_t i = 0; i < found.gl_pathc; ++i) {
      std::error_code error;
      const fs::path real = fs::canonical(found.gl_pathv[i], error);
      const bool is_text = !error && fs::is_regular_file(real, error) &&
                           fs::file_size(real, error) <= kLargestFile_bytes;
      if (is_text) files.push_back(real);
    }
  }
  globfree(&found);
  return files;
}

// Read once each; a file that is being read includes itself no more.
void AddIncluded(const std::string& config,
                 const fs::path& folder,
                 std::set<fs::path>* read,
                 std::string* whole) {
  for (const std::string_view line : RawLines(config)) {
    const std::string_view named = IncludedBy(line);
    const auto files =
        named.empty() ? std::vector<fs::path>() : FilesNamed(named, folder);
    if (files.empty()) whole->append(line).append("\n");
    for (const fs::path& file : files) {
      if (!read->insert(file).second) continue;
      AddIncluded(
          ReadTextFile(file, kLargestFile_bytes), file.parent_path(), read, whole);
    }
  }
}

// Of "Section 'x'" x; empty where there is none.
std::string Named(const std::string& says, const std::string& what) {
  std::smatch found;
  const std::regex words(what + " '([^']+)'", std::regex::icase);
  return std::regex_search(says, found, words) ? found[1].str() : "";
}

}  // namespace

std::vector<std::string_view> RawLines(std::string_view config) {
  std::vector<std::string_view> lines;
  while (!config.empty()) {
    std::string_view line = config.substr(0, config.find('\n'));
    config.remove_prefix(std::min(config.size(), line.size() + 1));
    if (line.ends_with('\r')) line.remove_suffix(1);
    lines.push_back(line);
  }
  return lines;
}

std::string WithAdded(const std::string& config, std::string_view lines) {
  if (lines.empty()) return config;
  std::size_t at = config.starts_with(kSaved) ? 0 : config.find("\n#*#");
  if (at == std::string::npos) {
    return config + (config.ends_with('\n') ? "" : "\n") + std::string(lines);
  }
  at += config[at] == '\n' ? 1 : 0;
  return config.substr(0, at) + std::string(lines) + "\n" + config.substr(at);
}

std::string WithIncluded(const std::string& config, const fs::path& folder) {
  if (folder.empty()) return config;
  std::string whole;
  std::set<fs::path> read;
  AddIncluded(config, folder, &read, &whole);
  return whole;
}

Place PlaceOfComplaint(const std::string& says,
                       const std::string& config,
                       const std::string& name) {
  const std::string section = Named(says, "section"), option = Named(says, "option");
  const PrinterCfg cfg(config, name);
  const CfgSetting* const setting = cfg.Find(section, option);
  if (setting != nullptr) {
    return {.file = name, .line = setting->value.line, .column = 1};
  }
  const auto titles = cfg.Sections(section.substr(0, section.find(' ')));
  if (std::ranges::find(titles, section) == titles.end()) return {.file = name};
  return cfg.PlaceOfSection(section);
}

}  // namespace caltwin

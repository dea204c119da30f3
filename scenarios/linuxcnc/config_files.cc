#include "scenarios/linuxcnc/config_files.h"

#include "sim/base/input_error.h"
#include "sim/base/text_file.h"
#include "sim/controllers/linuxcnc/config.h"

namespace caltwin {

namespace fs = std::filesystem;

LinuxCncFiles FilesBesideIni(const fs::path& ini) {
  LinuxCncFiles files = {
      {ini.filename().string(), ReadTextFile(ini, kLargestFile_bytes)}};
  const fs::path folder = fs::absolute(ini).parent_path();
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const bool is_one = entry.is_regular_file() &&
                        entry.file_size() <= kLargestFile_bytes &&
                        entry.path().filename() != ini.filename();
    if (!is_one) continue;
    files.emplace_back(entry.path().filename().string(),
                       ReadTextFile(entry.path(), kLargestFile_bytes));
  }
  return files;
}

std::string WithIniSetting(const std::string& ini,
                           const std::string& setting,
                           const std::string& place) {
  const auto point = setting.find('.'), equals = setting.find('=');
  if (equals == std::string::npos || point > equals) {
    throw InputError({.file = place},
                     "a section, a key and a value are wanted",
                     "as in JOINT_0.BACKLASH=0.05");
  }
  return linuxcnc::WithIniValue(ini,
                                setting.substr(0, point),
                                setting.substr(point + 1, equals - point - 1),
                                setting.substr(equals + 1));
}

}  // namespace caltwin

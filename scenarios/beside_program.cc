#include "scenarios/beside_program.h"

#include <system_error>

#include <fmt/format.h>

#include "sim/base/input_error.h"

namespace caltwin {

namespace fs = std::filesystem;

fs::path ProgramFolder() {
  std::error_code error;
  return fs::read_symlink("/proc/self/exe", error).parent_path();
}

fs::path FileBesideProgram(std::string_view name) {
  const fs::path folder = ProgramFolder();
  for (const fs::path& place : {folder, folder / "..", folder / "../lib/caltwin"}) {
    if (fs::exists(place / name)) return fs::canonical(place / name);
  }
  throw InputError({},
                   fmt::format("{} is not beside the program", name),
                   "build or install caltwin as a whole");
}

}  // namespace caltwin

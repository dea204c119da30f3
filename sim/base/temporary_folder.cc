#include "sim/base/temporary_folder.h"

#include <cerrno>
#include <charconv>
#include <csignal>
#include <string>
#include <system_error>

#include <fmt/format.h>
#include <stdlib.h>
#include <unistd.h>

#include "sim/base/input_error.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;

// Removes what owners left behind that were killed.
void Sweep(const std::string& begin, const fs::path& where) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(where, error)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(begin)) continue;
    int owner = 0;
    const auto read =
        std::from_chars(name.data() + begin.size(), name.data() + name.size(), owner);
    const bool has_owner = read.ec == std::errc() && owner > 0;
    if (has_owner && kill(owner, 0) != 0 && errno == ESRCH) {
      fs::remove_all(entry.path(), error);
    }
  }
}

}  // namespace

TemporaryFolder::TemporaryFolder(std::string_view begin, const fs::path& where) {
  Sweep(fmt::format("{}_", begin), where);
  std::string name = (where / fmt::format("{}_{}_XXXXXX", begin, getpid())).string();
  if (mkdtemp(name.data()) == nullptr) {
    throw InputError({.file = name}, "no temporary folder can be made");
  }
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

}  // namespace caltwin

#include "sim/link/pseudo_terminal.h"

#include <cerrno>
#include <cstdlib>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <termios.h>
#include <unistd.h>

#include "sim/base/input_error.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;

int OpenMaster(const std::string& option) {
  const int master = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (master < 0 || grantpt(master) != 0 || unlockpt(master) != 0) {
    throw InputError({}, fmt::format("{}: {}", option, SystemSays(errno)));
  }
  return master;
}

/// Held open here as well, so that a client's going does not end the terminal; raw, so
/// that nothing is echoed.
int OpenClientSide(const std::string& name, const std::string& option) {
  const int descriptor = open(name.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  termios mode{};
  if (descriptor < 0 || tcgetattr(descriptor, &mode) != 0) {
    throw InputError({}, fmt::format("{}: {}: {}", option, name, SystemSays(errno)));
  }
  cfmakeraw(&mode);
  tcsetattr(descriptor, TCSANOW, &mode);
  return descriptor;
}

void MakeLink(const std::string& target,
              const fs::path& path,
              const std::string& option) {
  std::error_code error;
  // Left by one that was killed: it leads nowhere, or by chance to this new terminal.
  const bool is_left =
      fs::is_symlink(path, error) &&
      (!fs::exists(path, error) || fs::read_symlink(path, error) == target);
  if (is_left) fs::remove(path, error);
  fs::create_symlink(target, path, error);
  if (error) {
    throw InputError({},
                     fmt::format("{} {}: {}", option, path.string(), error.message()),
                     "the path is made by caltwin and must not exist yet");
  }
}

}  // namespace

PseudoTerminal::PseudoTerminal(const fs::path& path, const std::string& option)
    : master_(OpenMaster(option)),
      client_side_(OpenClientSide(ptsname(master_.number()), option)),
      path_(path) {
  MakeLink(ptsname(master_.number()), path_, option);
}

PseudoTerminal::~PseudoTerminal() {
  std::error_code ignored;
  fs::remove(path_, ignored);
}

}  // namespace caltwin

#include "scenarios/klipper/host_process.h"

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "scenarios/beside_program.h"
#include "scenarios/spawn.h"
#include "sim/base/input_error.h"
#include "sim/controllers/klipper/host_time.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;

constexpr const char* kInstalls =
    "tools/setup.sh --controllers installs one in build/controllers";

}  // namespace

fs::path HostProgram(const std::string& stated) {
  const char* const variable = std::getenv("CALTWIN_KLIPPER_HOST");
  const std::string usual = variable != nullptr ? variable : "";
  const std::string named = stated.empty() ? usual : stated;
  if (!named.empty()) {
    if (fs::exists(named)) return fs::absolute(named);
    throw InputError({.file = named}, "there is no such host", kInstalls);
  }
  for (const char* const place :
       {"controllers/bin/kalico", "../controllers/bin/kalico"}) {
    const fs::path file = ProgramFolder() / place;
    if (fs::exists(file)) return fs::canonical(file);
  }
  return "kalico";
}

HostProcess::HostProcess() {
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    throw InputError({}, "a socket: " + SystemSays(errno));
  }
  ours_.Set(ends[0]);
  theirs_.Set(ends[1]);
}

HostProcess::~HostProcess() {
  if (pid_ < 0) return;
  kill(-pid_, SIGKILL);
  while (waitpid(pid_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

void HostProcess::Start(const fs::path& program, const fs::path& folder) {
  constexpr int kClock = 10;
  const auto in_folder = [&](std::string_view name) {
    return (folder / name).string();
  };
  const Descriptor nothing(open("/dev/null", O_RDONLY | O_CLOEXEC));
  constexpr int kNewFile = O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC;
  const Descriptor log(open(in_folder("host.log").c_str(), kNewFile, 0600));
  // The host asks git what version it is. Killed in the middle it would leave a lock in
  // whatever repository its folder happens to lie in, which is not its own.
  const std::string above = program.parent_path().parent_path().parent_path().string();
  const Spawned spawned =
      Spawn({.words = {program.string(),
                       in_folder("printer.cfg"),
                       "-l",
                       in_folder("klippy.log"),
                       "-a",
                       in_folder("api"),
                       "-I",
                       in_folder("tty")},
             .environment = {"LD_PRELOAD=" +
                                 FileBesideProgram("libcaltwin_host_time.so").string(),
                             fmt::format("{}={}", klipper::kHostTimeVariable, kClock),
                             "GIT_CEILING_DIRECTORIES=" + above,
                             "GIT_OPTIONAL_LOCKS=0"},
             .descriptors = {{nothing.number(), STDIN_FILENO},
                             {log.number(), STDOUT_FILENO},
                             {log.number(), STDERR_FILENO},
                             {theirs_.number(), kClock}}});
  if (spawned.error != 0) {
    throw InputError({},
                     fmt::format("{}: {}", program.string(), SystemSays(spawned.error)),
                     kInstalls);
  }
  pid_ = spawned.pid;
  theirs_.Close();
}

}  // namespace caltwin

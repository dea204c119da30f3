#include "scenarios/linuxcnc/sandbox.h"

#include <array>
#include <cerrno>
#include <csignal>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "scenarios/beside_program.h"
#include "scenarios/spawn.h"
#include "sim/base/input_error.h"
#include "sim/base/text_file.h"
#include "sim/machine/machine.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;

constexpr const char* kModules = "/usr/lib/linuxcnc/modules";
constexpr const char* kInstalls =
    "apt-get install linuxcnc-uspace linuxcnc-uspace-dev, or tools/setup.sh "
    "--controllers";
constexpr int kLine = 4, kAlive = 3;

int Ended(pid_t pid) {
  int status = 0;
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

pid_t Run(const SpawnAsked& asked) {
  const Spawned spawned = Spawn(asked);
  if (spawned.error == 0) return spawned.pid;
  throw InputError(
      {}, fmt::format("{}: {}", asked.words[0], SystemSays(spawned.error)), kInstalls);
}

// What comes with caltwin for LinuxCNC, in a folder of this run.
void CopyComponent(const fs::path& folder) {
  const fs::path from = ShareFolder() / "sim/controllers/linuxcnc/component";
  std::error_code error;
  fs::copy(from, folder / "component", fs::copy_options::recursive, error);
  if (!error) {
    fs::copy_file(
        FileBesideProgram("libcaltwin_linuxcnc_time.so"), folder / "time.so", error);
  }
  if (error) throw InputError({.file = from.string()}, error.message());
}

// LinuxCNC's own compiler of components makes ours for the version that is installed.
void Compile(const fs::path& folder) {
  const std::string log_file = (folder / "compile.log").string();
  const Descriptor log(
      open(log_file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600));
  const pid_t pid = Run(
      {.words = {"halcompile", "--compile", "caltwin.comp"},
       .folder = folder / "component",
       .descriptors = {{log.number(), STDOUT_FILENO}, {log.number(), STDERR_FILENO}}});
  if (Ended(pid) == 0) return;
  throw InputError({},
                   "LinuxCNC's halcompile does not compile caltwin's component:\n" +
                       ReadTextFile(log_file, kLargestFile_bytes),
                   kInstalls);
}

}  // namespace

LinuxCncSandbox::LinuxCncSandbox() {
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    throw InputError({}, "a socket: " + SystemSays(errno));
  }
  ours_.Set(ends[0]);
  theirs_.Set(ends[1]);
  if (pipe2(ends.data(), O_CLOEXEC) != 0) {
    throw InputError({}, "a pipe: " + SystemSays(errno));
  }
  watched_.Set(ends[0]);
  alive_.Set(ends[1]);
}

LinuxCncSandbox::~LinuxCncSandbox() {
  if (pid_ < 0) return;
  kill(-pid_, SIGKILL);
  Ended(pid_);
}

bool LinuxCncSandbox::HasEnded() {
  if (pid_ < 0) return true;
  if (waitpid(pid_, nullptr, WNOHANG) != pid_) return false;
  pid_ = -1;
  return true;
}

void LinuxCncSandbox::Start(const fs::path& folder, const std::string& ini) {
  if (!fs::exists(kModules)) {
    throw InputError({}, "LinuxCNC is not installed", kInstalls);
  }
  CopyComponent(folder);
  Compile(folder);
  const Descriptor nothing(open("/dev/null", O_RDONLY | O_CLOEXEC));
  const Descriptor log(open((folder / "linuxcnc.log").c_str(),
                            O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC,
                            0600));
  // LinuxCNC refuses to be run by root: inside, whoever runs it is an ordinary user,
  // who may still mount for as long as start.sh needs it.
  pid_ = Run({.words = {"unshare",
                        "--user",
                        "--map-user=1000",
                        "--map-group=1000",
                        "--keep-caps",
                        "--ipc",
                        "--net",
                        "--pid",
                        "--mount",
                        "--mount-proc",
                        "--fork",
                        "--kill-child",
                        (folder / "component/start.sh").string(),
                        folder.string(),
                        ini},
              .environment = {std::string("LINUXCNC_MODULES=") + kModules,
                              "CALTWIN_LINUXCNC_PAGE=/tmp/page",
                              // What it refuses is read in English.
                              "LC_ALL=C.UTF-8",
                              "LANGUAGE=",
                              fmt::format("CALTWIN_OPERATOR={}", kLine)},
              .descriptors = {{nothing.number(), STDIN_FILENO},
                              {log.number(), STDOUT_FILENO},
                              {log.number(), STDERR_FILENO},
                              {watched_.number(), kAlive},
                              {theirs_.number(), kLine}}});
  theirs_.Close();
  watched_.Close();
}

}  // namespace caltwin

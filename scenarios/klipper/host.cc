#include "scenarios/klipper/host.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <iterator>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "scenarios/klipper/host_api.h"
#include "sim/base/input_error.h"
#include "sim/controllers/klipper/lock_step.h"
#include "sim/link/pseudo_terminal.h"

extern char** environ;

namespace caltwin {
namespace {

namespace fs = std::filesystem;
using klipper::LockStep;

std::string TextOf(const fs::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void Write(const fs::path& file, const std::string& text) {
  std::ofstream(file) << text;
}

// A folder that goes with all that is in it, but for the host's log where it is wanted.
class WorkFolder {
 public:
  explicit WorkFolder(fs::path log) : log_(std::move(log)) {
    std::string name = (fs::temp_directory_path() / "caltwin_klipper_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) {
      throw InputError({}, fmt::format("{}: {}", name, SystemSays(errno)));
    }
    path_ = name;
  }
  ~WorkFolder() {
    std::error_code ignored;
    constexpr auto kOver = fs::copy_options::overwrite_existing;
    if (!log_.empty()) fs::copy_file(path_ / "klippy.log", log_, kOver, ignored);
    fs::remove_all(path_, ignored);
  }
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path log_, path_;
};

fs::path ProgramFolder() {
  std::error_code error;
  return fs::read_symlink("/proc/self/exe", error).parent_path();
}

// The library that gives the host its time: beside the program that was built (a test
// is one folder down), or where it was installed to.
fs::path HostTimeLibrary() {
  const fs::path folder = ProgramFolder();
  const std::string_view name = "libcaltwin_host_time.so";
  for (const fs::path& place : {folder, folder / "..", folder / "../lib/caltwin"}) {
    if (fs::exists(place / name)) return fs::canonical(place / name);
  }
  throw InputError({},
                   fmt::format("{} is not beside the program", name),
                   "build or install caltwin as a whole");
}

// The line of [mcu] that says where the chip is, with another place.
std::string WithSerial(const std::string& config, const fs::path& serial) {
  std::string text;
  bool is_in_mcu = false, is_found = false;
  std::size_t at = 0;
  while (at < config.size()) {
    const std::size_t end = std::min(config.find('\n', at), config.size());
    const std::string_view line(config.data() + at, end - at);
    if (line.starts_with("[")) is_in_mcu = line.starts_with("[mcu]");
    const bool is_serial = is_in_mcu && line.starts_with("serial");
    is_found = is_found || is_serial;
    text += is_serial ? "serial: " + serial.string() : std::string(line);
    text += '\n';
    at = end + 1;
  }
  if (is_found) return text;
  throw InputError({.file = "printer.cfg"},
                   "there is no [mcu] with a `serial:`",
                   "caltwin new klipper MACHINE --out printer.cfg writes one");
}

// Where the chip is by that configuration.
std::string SerialOf(const std::string& config) {
  const std::string_view key = "\nserial";
  const std::size_t at = config.find(key);
  if (at == std::string::npos) return "";
  const std::size_t from = config.find_first_not_of(" :=", at + key.size());
  return config.substr(from, config.find('\n', from) - from);
}

// A program and what it was started with, ended with its group.
class Child {
 public:
  Child(const std::vector<std::string>& words,
        const std::vector<std::string>& environment,
        int descriptor,
        int as_descriptor,
        const fs::path& log) {
    std::vector<char*> arguments, variables;
    for (const std::string& word : words)
      arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    for (char** one = environ; *one != nullptr; ++one) {
      const std::string_view variable(*one);
      const bool is_ours = variable.starts_with("LD_PRELOAD=") ||
                           variable.starts_with(klipper::kHostTimeVariable);
      if (!is_ours) variables.push_back(*one);
    }
    for (const std::string& one : environment) {
      variables.push_back(const_cast<char*>(one.c_str()));
    }
    variables.push_back(nullptr);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
    constexpr int kNewFile = O_WRONLY | O_CREAT | O_APPEND;
    posix_spawn_file_actions_addopen(&files, 1, log.c_str(), kNewFile, 0600);
    posix_spawn_file_actions_adddup2(&files, 1, 2);
    posix_spawn_file_actions_adddup2(&files, descriptor, as_descriptor);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    const int error = posix_spawnp(
        &pid_, arguments[0], &files, &attributes, arguments.data(), variables.data());
    posix_spawn_file_actions_destroy(&files);
    posix_spawnattr_destroy(&attributes);
    if (error != 0) {
      throw InputError({},
                       fmt::format("{}: {}", words[0], SystemSays(error)),
                       "tools/setup.sh --controllers installs a host");
    }
  }
  ~Child() {
    kill(-pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

 private:
  pid_t pid_ = 0;
};

struct Socket {
  Descriptor ours{-1}, theirs{-1};
};

std::array<int, 2> SocketPair() {
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    throw InputError({}, "a socket: " + SystemSays(errno));
  }
  return ends;
}

fs::path UniqueSerial() {
  static std::atomic<int> number{0};
  // The host takes what begins so as it is, without the settings of a serial port.
  return fmt::format("/tmp/klipper_host_caltwin_{}_{}", getpid(), ++number);
}

// What the host includes stands beside its printer.cfg; it may read it there, and write
// nothing back.
void LinkNeighbours(const fs::path& from, const fs::path& to) {
  if (from.empty()) return;
  for (const fs::directory_entry& entry : fs::directory_iterator(from)) {
    std::error_code is_there_already;
    fs::create_symlink(
        fs::absolute(entry.path()), to / entry.path().filename(), is_there_already);
  }
}

}  // namespace

// Everything of one host, in the order in which it is needed.
class KlipperHost::Parts {
 public:
  Parts(klipper::Board* board, const KlipperHostOptions& options)
      : options_(options),
        folder_(options.log),
        terminal_(UniqueSerial(), "the host's serial line"),
        ends_(SocketPair()),
        ours_(ends_[0]),
        theirs_(ends_[1]),
        api_(folder_.path() / "api"),
        lock_step_(board, terminal_.number(), ours_.number()) {
    Write(config(), WithSerial(options.config + "\n" + options.add, terminal_.path()));
    LinkNeighbours(options.beside, folder_.path());
    Start();
    WaitUntilReady();
  }

  HostAnswer Say(std::string_view line);
  void Hear(HostAnswer* answer);
  std::string Config() const {
    return WithSerial(TextOf(config()), SerialOf("\n" + options_.config));
  }
  fs::path config() const { return folder_.path() / "printer.cfg"; }
  std::string LogEnd() const;
  double printer_s() const { return lock_step_.host_s(); }
  Motors MotorsNow() const {
    return lock_step_.chip().MotorsAt(lock_step_.chip().now());
  }

 private:
  void Start();
  void WaitUntilReady();
  void Run(const std::function<bool()>& is_done);
  nlohmann::json Info();

  KlipperHostOptions options_;
  WorkFolder folder_;
  PseudoTerminal terminal_;
  std::array<int, 2> ends_;
  Descriptor ours_, theirs_;
  HostApi api_;
  LockStep lock_step_;
  std::optional<Child> child_{};
};

void KlipperHost::Parts::Start() {
  constexpr int kClock = 10;
  const auto in_folder = [&](std::string_view name) {
    return (folder_.path() / name).string();
  };
  const fs::path program =
      options_.program.empty() ? HostProgram("") : options_.program;
  child_.emplace(std::vector<std::string>{program.string(),
                                          config().string(),
                                          "-l",
                                          in_folder("klippy.log"),
                                          "-a",
                                          in_folder("api"),
                                          "-I",
                                          in_folder("tty")},
                 std::vector<std::string>{
                     "LD_PRELOAD=" + HostTimeLibrary().string(),
                     fmt::format("{}={}", klipper::kHostTimeVariable, kClock)},
                 theirs_.number(),
                 kClock,
                 in_folder("host.log"));
  close(theirs_.Release());
}

std::string KlipperHost::Parts::LogEnd() const {
  constexpr std::size_t kMost = 2000;
  const std::string printed = TextOf(folder_.path() / "host.log");
  const std::string text =
      printed.empty() ? TextOf(folder_.path() / "klippy.log") : printed;
  return text.size() > kMost ? text.substr(text.size() - kMost) : text;
}

void KlipperHost::Parts::Run(const std::function<bool()>& is_done) {
  switch (lock_step_.Run(is_done, options_.patience, options_.stop)) {
    case LockStep::End::kDone:
      return;
    case LockStep::End::kStopped:
      throw HostLost("interrupted");
    case LockStep::End::kHostEnded:
      throw HostLost("the host has ended; it wrote last:\n" + LogEnd());
    case LockStep::End::kHostSilent:
      throw HostLost(
          fmt::format("the host has worked for {} s without waiting for anything; it "
                      "wrote last:\n{}",
                      options_.patience.count() / 1000,
                      LogEnd()));
  }
}

// What it says of itself; not before it listens.
nlohmann::json KlipperHost::Parts::Info() {
  nlohmann::json info;
  std::optional<int> asked;
  Run([&] {
    if (!api_.is_open() && !api_.Open()) return false;
    api_.Receive();
    if (!api_.is_open()) asked.reset();  // It begins anew.
    if (api_.is_open() && !asked) asked = api_.Ask("info", nlohmann::json::object());
    const auto answer = asked ? api_.TakeAnswer(*asked) : std::nullopt;
    if (answer) info = *answer;
    return answer.has_value();
  });
  return info;
}

void KlipperHost::Parts::WaitUntilReady() {
  constexpr double kPatience_s = 60, kBetween_s = 0.2;
  const double until_s = printer_s() + kPatience_s;
  for (;;) {
    const nlohmann::json answer = Info();
    const nlohmann::json info = answer.value("result", nlohmann::json::object());
    const std::string state = info.value("state", "");
    if (state == "ready") break;
    const std::string says = info.value("state_message", "");
    if (state == "error" && says.find("mcu") == std::string::npos) {
      throw InputError({.file = "printer.cfg"},
                       "the host does not take it: " + says.substr(0, says.find('\n')));
    }
    if (state != "startup" || printer_s() > until_s) {
      throw HostLost(fmt::format("the host is not ready but in {}: {}", state, says));
    }
    const double again_s = printer_s() + kBetween_s;
    Run([&] { return printer_s() >= again_s; });
  }
  const int asked = api_.Ask("gcode/subscribe_output",
                             {{"response_template", nlohmann::json::object()}});
  Run([&] {
    api_.Receive();
    return api_.TakeAnswer(asked).has_value();
  });
}

// What it prints until then, and whether it begins anew.
void KlipperHost::Parts::Hear(HostAnswer* answer) {
  api_.Receive();
  for (std::string& printed : api_.TakePrinted()) {
    if (printed.find("Klipper state: Disconnect") != std::string::npos) {
      answer->has_restarted = true;
    }
    const std::size_t unknown = printed.find("Unknown command:");
    if (unknown != std::string::npos && !answer->refusal) {
      answer->refusal = printed.substr(unknown);
    }
    answer->lines.push_back(std::move(printed));
  }
  if (!api_.is_open()) answer->has_restarted = true;
}

HostAnswer KlipperHost::Parts::Say(std::string_view line) {
  HostAnswer answer;
  const double until_s = printer_s() + options_.longest_s;
  const int asked = api_.Ask("gcode/script", {{"script", std::string(line)}});
  bool is_over = false;
  Run([&] {
    Hear(&answer);
    const auto said = api_.TakeAnswer(asked);
    if (said && said->contains("error")) {
      answer.refusal = (*said)["error"].value("message", said->dump());
    }
    is_over = said || !api_.is_open();
    return is_over || printer_s() > until_s;
  });
  if (!is_over) {
    throw HostLost(fmt::format("'{}' has not ended after {} s of the printer's time",
                               line,
                               options_.longest_s));
  }
  // A stop or a restart that it was told to do follows its answer; to begin anew the
  // host may first stop the chip.
  constexpr double kSettles_s = 0.002, kRestarts_s = 3;
  const auto hear_for = [&](double s) {
    const double until_s = printer_s() + s;
    Run([&] {
      Hear(&answer);
      return answer.has_restarted || printer_s() >= until_s;
    });
  };
  hear_for(kSettles_s);
  if (!answer.has_restarted && lock_step_.chip().shutdown()) hear_for(kRestarts_s);
  if (answer.has_restarted) {
    Run([&] {
      api_.Receive();
      return !api_.is_open();
    });
    WaitUntilReady();
  }
  if (const auto why = lock_step_.chip().shutdown())
    answer.shut_down = std::string(*why);
  return answer;
}

KlipperHost::KlipperHost(klipper::Board* board, const KlipperHostOptions& options)
    : parts_(std::make_unique<Parts>(board, options)) {}

KlipperHost::~KlipperHost() = default;

HostAnswer KlipperHost::Say(std::string_view line) {
  return parts_->Say(line);
}

std::string KlipperHost::Config() const {
  return parts_->Config();
}

std::string KlipperHost::LogEnd() const {
  return parts_->LogEnd();
}

Motors KlipperHost::MotorsNow() const {
  return parts_->MotorsNow();
}

double KlipperHost::printer_s() const {
  return parts_->printer_s();
}

fs::path HostProgram(const std::string& stated) {
  const char* const variable = std::getenv("CALTWIN_KLIPPER_HOST");
  const std::string named = !stated.empty()       ? stated
                            : variable != nullptr ? variable
                                                  : "";
  if (!named.empty()) {
    if (fs::exists(named)) return fs::absolute(named);
    throw InputError({.file = named},
                     "there is no such host",
                     "tools/setup.sh --controllers installs one in build/controllers");
  }
  for (const char* const place :
       {"controllers/bin/kalico", "../controllers/bin/kalico"}) {
    if (fs::exists(ProgramFolder() / place))
      return fs::canonical(ProgramFolder() / place);
  }
  return "kalico";
}

std::vector<SavedSetting> SavedSettingsOf(std::string_view config) {
  constexpr std::string_view kMark = "#*#";
  std::vector<SavedSetting> saved;
  std::string section;
  std::size_t at = 0;
  while (at < config.size()) {
    const std::size_t end = std::min(config.find('\n', at), config.size());
    std::string_view line = config.substr(at, end - at);
    at = end + 1;
    if (!line.starts_with(kMark)) continue;
    line.remove_prefix(kMark.size());
    const bool goes_on = line.starts_with(" \t") || line.starts_with("  ");
    const std::size_t first = line.find_first_not_of(" \t");
    if (first == std::string_view::npos) continue;
    line = line.substr(first);
    const std::size_t equals = line.find(" = ");
    if (line.starts_with("[") && line.ends_with("]")) {
      section = line.substr(1, line.size() - 2);
    } else if (goes_on && !saved.empty()) {
      saved.back().value +=
          (saved.back().value.empty() ? "" : "\n") + std::string(line);
    } else if (const bool is_begun = line.ends_with(" =");
               is_begun || equals != line.npos) {
      const std::string_view option =
          line.substr(0, is_begun ? line.size() - 2 : equals);
      const std::string_view value = is_begun ? "" : line.substr(equals + 3);
      saved.push_back({section, std::string(option), std::string(value)});
    }
  }
  return saved;
}

}  // namespace caltwin

#include "tools/commands/api/own_program.h"

#include <csignal>
#include <string_view>

#include <fmt/format.h>
#include <sys/prctl.h>
#include <unistd.h>

#include "scenarios/child_process.h"
#include "sim/base/input_error.h"
#include "sim/base/text_file.h"
#include "tools/commands/command.h"
#include "tools/server/problem.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;

constexpr const char* kServedBy = "CALTWIN_SERVED_BY";
constexpr std::size_t kMostMemory_bytes = 4'000'000'000;
constexpr std::size_t kMostFaults_bytes = 100'000;

// stderr as InputError had it: a fault a line, its hint indented below.
std::vector<std::string> MessagesOf(std::string_view text) {
  std::vector<std::string> messages;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string line(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.starts_with("  ") && !messages.empty()) {
      messages.back() += "\n" + line;
    } else if (!line.empty()) {
      messages.push_back(line);
    }
  }
  return messages;
}

[[noreturn]] void ThrowFor(const ChildEnd& end) {
  using enum ChildEnd::How;
  if (end.how == kExited && end.code == kBadInput) {
    const std::vector<ProblemFault> faults = FaultsOf(MessagesOf(end.last_words));
    throw Problem(422, faults.empty() ? "bad input" : faults.front().detail, faults);
  }
  if (end.how == kTimedOut) throw Problem(504, "it took too long and was ended");
  if (end.how == kInterrupted) throw Problem(503, "it was stopped");
  fmt::print(stderr, "caltwin {}: {}\n", ToString(end), Printable(end.last_words));
  throw Problem(500, "it " + ToString(end) + "; the server's terminal says more");
}

}  // namespace

bool IsAnotherAlive(int process) {
  if (process <= 0 || process == getpid()) return false;
  // One that has ended and was not waited for has no program; a number that was given
  // out again has another.
  std::error_code failed;
  const auto name_of = [&](const std::string& which) {
    std::string name = fs::read_symlink(fmt::format("/proc/{}/exe", which), failed)
                           .filename()
                           .string();
    return name.substr(0, name.find(" (deleted)"));
  };
  const std::string theirs = name_of(std::to_string(process));
  return !failed && theirs == name_of("self");
}

void EndWithServer() {
  const char* const server = std::getenv(kServedBy);
  if (server == nullptr) return;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (std::to_string(getppid()) != server) std::_Exit(kLost);  // It is gone already.
}

std::string RunOwnProgram(const OwnCommand& command) {
  ChildCommand child{.words = {"/proc/self/exe"},
                     .folder = command.folder,
                     .patience = command.patience,
                     .stop = command.stop,
                     .shows_errors = false,
                     .last_words_bytes = kMostFaults_bytes,
                     .most_memory_bytes = kMostMemory_bytes,
                     .environment = {fmt::format("{}={}", kServedBy, getpid())}};
  if (command.is_confined) child.environment.emplace_back("CALTWIN_CONFINED=1");
  child.words.insert(child.words.end(), command.words.begin(), command.words.end());
  std::string said;
  const ChildEnd end = ConverseWith(child, [&](std::string_view line) {
    if (!command.takes(line)) said += std::string(line) + "\n";
    return std::string();
  });
  const bool is_done = end.how == ChildEnd::How::kExited &&
                       (end.code == kPassed || end.code == kCheckFailed);
  if (!is_done) ThrowFor(end);
  return said;
}

}  // namespace caltwin

#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace caltwin {

/// How a child process ended.
struct ChildEnd {
  enum class How { kExited, kKilled, kTimedOut, kNotStarted, kInterrupted };
  How how = How::kExited;
  int code = 0;              ///< Exit code, signal, or errno.
  std::string last_words{};  ///< The end of what it wrote to its stderr.
};

/// In words: "exited with 1", "was killed by signal 9", "took longer than ...".
std::string ToString(const ChildEnd& end);

struct ChildCommand {
  std::vector<std::string> words{};  ///< Program (sought in PATH) and arguments.
  std::filesystem::path folder{};    ///< Where it runs; empty: here.
  std::chrono::milliseconds patience{600'000};
  /// @name Of a child that works for a server
  const std::atomic<bool>* stop = nullptr;  ///< True: it is ended, as by Ctrl-C.
  bool shows_errors = true;                 ///< Whether its stderr is shown on ours.
  std::size_t last_words_bytes = 2000;      ///< So much of its stderr is kept.
  std::size_t most_memory_bytes = 0;        ///< Of its address space; 0: no limit.
  std::vector<std::string> environment{};   ///< "NAME=VALUE", beside ours.
};

/// Answers one line; what it returns is written back as it is.
using AnswerLine = std::function<std::string(std::string_view line)>;

/// Runs a program, answers every line it writes to its stdout, shows its stderr on
/// ours, and waits for it to end.
///
/// Never hangs and leaves nothing behind: both directions are polled, the child leads a
/// process group that is killed when the patience ends or Ctrl-C is pressed, and the
/// child is always waited for. A child that does not read its answers loses them (no
/// SIGPIPE). A line longer than 64 kB ends it too, as a fault of its own.
ChildEnd ConverseWith(const ChildCommand& command, const AnswerLine& answer);

}  // namespace caltwin

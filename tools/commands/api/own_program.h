#pragma once

#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace caltwin {

/// What `caltwin` itself is given to do.
struct OwnCommand {
  std::vector<std::string> words{};  ///< "diagnose", "data.csv".
  std::filesystem::path folder{};    ///< Where it runs.
  std::chrono::seconds patience{120};
  const std::atomic<bool>* stop = nullptr;
  /// Files that its files name (`extends:`, `machine:`) lie in its folder, or are
  /// machines that came with the program.
  bool is_confined = true;
  /// Is shown every line of stdout as it comes; what it takes is not in the answer.
  std::function<bool(std::string_view line)> takes = [](std::string_view) {
    return false;
  };
};

/// Whether another process of this program has that number.
bool IsAnotherAlive(int process);

/// Of such a process: ends with the server that began it, also where that was killed.
void EndWithServer();

/// Runs this very program in a process of its own, so that no file a client sends stops
/// the server: at most 4 GB, no longer than its patience. What it printed on stdout;
/// exit codes 0 and 1 are both done. Throws Problem: 422 with the faults of a refused
/// input, 504 where it took too long, 503 where it was stopped, 500 else.
std::string RunOwnProgram(const OwnCommand& command);

}  // namespace caltwin

#pragma once

#include <csignal>
#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <sys/types.h>

namespace caltwin {

/// A process to be started.
struct SpawnAsked {
  std::vector<std::string> words{};        ///< Program (sought in PATH) and arguments.
  std::filesystem::path folder{};          ///< Where it runs; empty: here.
  std::vector<std::string> environment{};  ///< "NAME=VALUE", in place of ours.
  /// Descriptors of ours and what they are there; it has no others.
  std::vector<std::pair<int, int>> descriptors{};
  std::size_t most_memory_bytes = 0;  ///< Of its address space; 0: no limit.
  sigset_t blocked{};                 ///< Signals that it begins with blocked.
};

struct Spawned {
  pid_t pid = -1;
  int error = 0;  ///< Why it was not started.
};

/// Starts it as the leader of a process group of its own, SIGPIPE and SIGINT as usual.
/// Whoever starts it ends the group and waits for it.
Spawned Spawn(const SpawnAsked& asked);

}  // namespace caltwin

#include "scenarios/spawn.h"

#include <algorithm>
#include <string_view>

#include <spawn.h>
#include <sys/resource.h>
#include <unistd.h>

extern char** environ;

namespace caltwin {
namespace {

std::vector<char*> PointersTo(std::vector<std::string>* texts) {
  std::vector<char*> pointers;
  for (std::string& text : *texts) pointers.push_back(text.data());
  return pointers;
}

std::string_view NameOf(std::string_view variable) {
  return variable.substr(0, variable.find('='));
}

// Those of ours that are not given anew: where a name stands twice, not everybody takes
// the same one.
std::vector<std::string> EnvironmentOf(const SpawnAsked& asked) {
  std::vector<std::string> all = asked.environment;
  for (char** one = environ; *one != nullptr; ++one) {
    const bool is_given = std::ranges::any_of(
        asked.environment,
        [&](const std::string& given) { return NameOf(given) == NameOf(*one); });
    if (!is_given) all.emplace_back(*one);
  }
  return all;
}

}  // namespace

Spawned Spawn(const SpawnAsked& asked) {
  posix_spawn_file_actions_t actions{};
  posix_spawn_file_actions_init(&actions);
  for (const auto& [ours, theirs] : asked.descriptors) {
    posix_spawn_file_actions_adddup2(&actions, ours, theirs);
  }
  if (!asked.folder.empty()) {
    posix_spawn_file_actions_addchdir_np(&actions, asked.folder.c_str());
  }
  posix_spawnattr_t attributes{};
  posix_spawnattr_init(&attributes);
  sigset_t defaults{};
  sigemptyset(&defaults);
  sigaddset(&defaults, SIGPIPE);
  sigaddset(&defaults, SIGINT);
  posix_spawnattr_setsigdefault(&attributes, &defaults);
  posix_spawnattr_setsigmask(&attributes, &asked.blocked);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(
      &attributes,
      POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETPGROUP);
  std::vector<std::string> words = asked.words, variables = EnvironmentOf(asked);
  std::vector<char*> arguments = PointersTo(&words),
                     environment = PointersTo(&variables);
  arguments.push_back(nullptr);
  environment.push_back(nullptr);
  Spawned spawned;
  spawned.error = posix_spawnp(&spawned.pid,
                               arguments[0],
                               &actions,
                               &attributes,
                               arguments.data(),
                               environment.data());
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
  if (spawned.error == 0 && asked.most_memory_bytes > 0) {
    const rlimit most{asked.most_memory_bytes, asked.most_memory_bytes};
    prlimit(spawned.pid, RLIMIT_AS, &most, nullptr);
  }
  return spawned;
}

}  // namespace caltwin

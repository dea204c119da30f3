#include "tests/blind/diagnosis.h"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>

extern char** environ;

namespace blind {
namespace {

namespace fs = std::filesystem;

/// Runs a program to its end, its output into `log`; its exit code, or -1.
int RunProgram(const std::vector<std::string>& words, const std::string& log) {
  std::vector<char*> argv;
  for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(
      &actions, 1, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  posix_spawn_file_actions_adddup2(&actions, 1, 2);
  pid_t child = 0;
  const int failed =
      posix_spawnp(&child, argv[0], &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) return -1;
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

nlohmann::json ReadJson(const fs::path& file) {
  std::ifstream stream(file);
  return nlohmann::json::parse(stream, nullptr, /*allow_exceptions=*/false);
}

}  // namespace

nlohmann::json Diagnose(const Diagnoser& diagnoser,
                        const std::string& folder_name,
                        const DiagnosisFiles& files) {
  const fs::path folder(folder_name);
  std::vector<std::string> words = {"timeout",
                                    std::to_string(diagnoser.limit_s),
                                    diagnoser.binary,
                                    "diagnose",
                                    (folder / "DATA.csv").string(),
                                    "--machine",
                                    (folder / files.machine).string(),
                                    "--json",
                                    (folder / files.answer).string()};
  if (!files.extend.empty()) {
    words.insert(words.end(), {"--extend", (folder / files.extend).string()});
  }
  const fs::path answer = folder / files.answer;
  fs::remove(answer);
  if (RunProgram(words, answer.string() + ".log") != 0) return nullptr;
  return ReadJson(answer);
}

Judgement Examine(const Diagnoser& diagnoser, const CaseRequest& request) {
  Case made;
  MakeCase(request, &made);
  const std::string cause = request.hidden.empty() ? "" : request.hidden[0].cause + "_";
  const fs::path folder = fs::path(diagnoser.folder) /
                          fmt::format("{}_{}{}", request.kind, cause, request.seed);
  WriteCase(made, folder.string());
  const auto begin = std::chrono::steady_clock::now();
  const auto answer =
      Diagnose(diagnoser, folder.string(), {.extend = "machine.ext.yaml"});
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  nlohmann::json again = nullptr;
  if (answer.is_object() && fs::exists(folder / "machine.ext.yaml")) {
    again = Diagnose(diagnoser,
                     folder.string(),
                     {.machine = "machine.ext.yaml", .answer = "again.json"});
  }
  const auto truth = nlohmann::json::parse(TruthJson(made));
  Judgement judgement = Judge(truth, answer, again);
  judgement.seconds = took.count();
  if (!diagnoser.keep) fs::remove_all(folder);
  return judgement;
}

}  // namespace blind

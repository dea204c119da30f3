#include "tests/blind/diagnosis.h"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <vector>

#include <fmt/format.h>

#include "tests/blind/physics_case.h"
#include "tests/blind/program.h"

namespace blind {
namespace {

namespace fs = std::filesystem;

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
                                    (folder / files.answer).string(),
                                    "--replay",
                                    files.replay};
  if (!files.extend.empty()) {
    words.insert(words.end(), {"--extend", (folder / files.extend).string()});
  }
  if (!files.loop.empty()) {
    words.insert(words.end(),
                 {"--closed-loop", "twin:" + (folder / files.loop).string()});
  }
  const fs::path answer = folder / files.answer;
  fs::remove(answer);
  if (RunProgram(words, answer.string() + ".log") != 0) return nullptr;
  return ReadJson(answer);
}

Judgement Examine(const Diagnoser& diagnoser, const CaseRequest& request) {
  const std::string cause = request.hidden.empty() ? "" : request.hidden[0].cause + "_";
  const fs::path folder =
      fs::path(diagnoser.folder) / fmt::format("{}{}_{}{}",
                                               request.physics ? "physics_" : "",
                                               request.kind,
                                               cause,
                                               request.seed);
  Case made;
  if (request.physics) {
    const Simulator simulator{.binary = diagnoser.binary,
                              .folder = folder.string(),
                              .model = diagnoser.model,
                              .keep_built = request.kind == "loop"};
    MakePhysicsCase(simulator, request, &made);
  } else {
    MakeCase(request, &made);
  }
  WriteCase(made, folder.string());
  const auto begin = std::chrono::steady_clock::now();
  const bool is_loop = request.kind == "loop";
  const auto answer = Diagnose(diagnoser,
                               folder.string(),
                               {.extend = is_loop ? "" : "machine.ext.yaml",
                                .loop = is_loop ? "built.yaml" : "",
                                .replay = request.physics ? "physics" : "none"});
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

#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "tests/blind/case.h"
#include "tests/blind/judge.h"

namespace blind {

/// The program under test, run as anybody runs it.
struct Diagnoser {
  std::string binary{};             ///< Path of `caltwin`.
  std::string folder{};             ///< Scratch; each case has its own folder in it.
  std::string model = BLIND_MODEL;  ///< Un-edited, of a router: for physics.
  int limit_s = 120;
  bool keep = false;  ///< Keep the folders.
};

/// Which files of a folder a diagnosis reads and writes.
struct DiagnosisFiles {
  std::string machine = "machine.yaml";
  std::string answer = "answer.json";
  std::string extend{};  ///< Empty: no extended machine is asked for.
  std::string loop{};    ///< Machine to measure on until one cause is left.
  /// "physics" takes the rows again in MuJoCo: most of the time a diagnosis needs.
  std::string replay = "none";
};

/// The answer to the data in `folder`; null where there was none.
nlohmann::json Diagnose(const Diagnoser& diagnoser,
                        const std::string& folder,
                        const DiagnosisFiles& files = {});

/// Makes the case, has it diagnosed, diagnoses again with the extended machine, judges.
/// The diagnosis gets the data and the machine file; the truth stays in this process.
Judgement Examine(const Diagnoser& diagnoser, const CaseRequest& request);

}  // namespace blind

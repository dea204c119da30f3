#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "tests/blind/case.h"
#include "tests/blind/judge.h"

namespace blind {

/// The program under test, run as anybody runs it.
struct Diagnoser {
  std::string binary{};  ///< Path of `caltwin`.
  std::string folder{};  ///< Scratch; each case has its own folder in it.
  int limit_s = 120;
  bool keep = false;  ///< Keep the folders.
};

/// Makes the case, has it diagnosed, diagnoses again with the extended machine, judges.
/// The diagnosis gets the data and the machine file; the truth stays in this process.
Judgement Examine(const Diagnoser& diagnoser, const CaseRequest& request);

}  // namespace blind

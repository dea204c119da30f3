#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "scenarios/file_kind.h"
#include "scenarios/kinds/truth_file.h"
#include "scenarios/machine_file.h"
#include "scenarios/scenario.h"
#include "scenarios/study/study.h"
#include "sim/machine/machine.h"
#include "sim/measure/data_header.h"
#include "sim/measure/plan.h"
#include "sim/measure/rows.h"
#include "tools/commands/command.h"

namespace caltwin {
namespace {

struct ValidateAsked {
  std::vector<std::string> files{};
};

// Plans it as `plan` and `simulate` do, where it says for which machine.
std::vector<std::string> CheckPlan(const Plan& plan) {
  if (plan.machine.empty()) return {};
  const auto machine =
      FindMachine(plan.machine, plan.file.parent_path(), {.file = plan.file.string()});
  PlanSession(plan, ReadMachineWithTip(machine).machine, plan.seed);
  return {};
}

// Reads a file as what it is, for what is to be noted of it; throws InputError where it
// is not that.
std::vector<std::string> Check(const std::string& file, FileKind kind) {
  switch (kind) {
    case FileKind::kScenario:
      return ReadScenario(file).notes;
    case FileKind::kMachine:
      return ReadAnyMachineFile(file).draws;
    case FileKind::kTruth:
      CheckTruthFile(file);
      return {};
    case FileKind::kData:
      ReadRows(file);
      return {};
    case FileKind::kDataHeader:
      ReadDataHeader(file);
      return {};
    case FileKind::kPlan:
      return CheckPlan(ReadPlan(file));
    case FileKind::kStudy:
      return ReadStudy(file).notes;
  }
  return {};
}

int Validate(const ValidateAsked& options) {
  std::vector<std::string> faults;
  for (const std::string& file : options.files) {
    try {
      const FileKind kind = KindOf(file);
      const std::vector<std::string> notes = Check(file, kind);
      std::cout << fmt::format("{}: {}, no faults\n", file, ToString(kind));
      for (const std::string& note : notes) std::cout << note << '\n';
    } catch (const InputError& error) {
      faults.insert(faults.end(), error.faults().begin(), error.faults().end());
    }
  }
  if (!faults.empty()) throw InputError(faults);
  return kPassed;
}

}  // namespace

Action DeclareValidate(CLI::App* app) {
  auto options = std::make_shared<ValidateAsked>();
  app->add_option("FILE", options->files, "files of any kind caltwin reads")
      ->required();
  app->footer(
      "A file's own keys say what it is: calibrate or controller a scenario, "
      "kinematics "
      "or extends a machine, effects or settings alone a truth file, campaigns as a "
      "list "
      "a plan, campaigns or artefacts (or a .csv of the same name) a data header, "
      "study "
      "a study. A .csv holds measured rows.");
  return [options] {
    return Validate(*options);
  };
}

}  // namespace caltwin

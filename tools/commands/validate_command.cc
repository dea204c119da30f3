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
#include "scenarios/kinds/motor_stage_scenario.h"
#include "scenarios/machine_file.h"
#include "scenarios/scenario.h"
#include "scenarios/study/study.h"
#include "sim/kinds/delta/effects.h"
#include "sim/machine/machine.h"
#include "sim/machine/motor_stage.h"
#include "sim/measure/data_header.h"
#include "sim/measure/plan.h"
#include "sim/measure/rows.h"
#include "tools/commands/command.h"

namespace caltwin {
namespace {

struct Options {
  std::vector<std::string> files{};
};

void ReadTruthOf(const std::filesystem::path& machine_file, const std::string& file) {
  if (IsMotorStage(machine_file)) {
    ReadMotorTruthFile(file, ReadMotorStage(machine_file));
    return;
  }
  const Machine machine = ReadMachine(machine_file);
  if (machine.delta) {
    ReadDeltaTruthFile(file, machine);
  } else {
    ReadTruthFile(file, machine);
  }
}

// A truth file does not say whose it is: sound if it is sound of any kind of machine,
// else told as of the kind that it fits best.
void ReadTruth(const std::string& file) {
  std::optional<InputError> least;
  for (const char* name : {"gantry_router",
                           "delta_printer",
                           "triple_z_printer",
                           "z_station",
                           "motor_stage"}) {
    try {
      ReadTruthOf(ShareFolder() / "models" / name / "machine.yaml", file);
      return;
    } catch (const InputError& error) {
      const std::string_view text = error.what();
      if (!least || text.size() < std::string_view(least->what()).size()) least = error;
    }
  }
  throw *least;
}

// Reads a file as what it is, for what is to be noted of it; throws InputError where it
// is not that.
std::vector<std::string> Check(const std::string& file, FileKind kind) {
  switch (kind) {
    case FileKind::kScenario:
      return ReadScenario(file).notes;
    case FileKind::kMachine:
      if (!IsMotorStage(file)) return ReadAnyMachineFile(file).draws;
      ReadMotorStage(file);
      return {};
    case FileKind::kTruth:
      ReadTruth(file);
      return {};
    case FileKind::kData:
      ReadRows(file);
      return {};
    case FileKind::kDataHeader:
      ReadDataHeader(file);
      return {};
    case FileKind::kPlan:
      ReadPlan(file);
      return {};
    case FileKind::kStudy:
      return ReadStudy(file).notes;
  }
  return {};
}

int Validate(const Options& options) {
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
  auto options = std::make_shared<Options>();
  app->add_option("FILE", options->files, "files of any kind caltwin reads")
      ->required();
  app->footer(
      "The kind is told by the top-level key: calibrate (scenario), kinematics or "
      "extends (machine), effects or settings alone (truth), campaigns, artefacts or a "
      ".csv of "
      "the same name (data header), campaigns as a list (plan), or a .csv (measured "
      "rows).");
  return [options] {
    return Validate(*options);
  };
}

}  // namespace caltwin

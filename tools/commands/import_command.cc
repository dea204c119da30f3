#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "calibration/diagnosis/plausible.h"
#include "sim/base/text_file.h"
#include "sim/measure/import/import.h"
#include "sim/measure/rows.h"
#include "tools/commands/command.h"
#include "tools/commands/import_account.h"
#include "tools/commands/spare_files.h"

namespace caltwin {

namespace fs = std::filesystem;

namespace {

struct ImportAsked {
  std::vector<std::string> words{};
  std::string kind{};
  std::string file{};
  std::string out{};
  std::string machine_out{};
  double step_mm = 0;
  ImportOptions import{};
};

/// What stands in a file that cannot be true, however it was read.
void RefuseImplausible(const std::vector<Doubt>& doubts, const std::string& file) {
  Faults faults;
  for (const Doubt& doubt : doubts) {
    if (doubt.refuse) faults.Add({.file = file}, doubt.message, doubt.hint);
  }
  faults.ThrowIfAny();
}

void Print(const char* title, const std::vector<std::string>& sentences) {
  for (const std::string& sentence : sentences) {
    std::cout << fmt::format("{:<11}{}\n", title, sentence);
  }
}

void PrintNext(const Imported& imported, const ImportAsked& options) {
  const std::string& out = options.out;
  const std::string& machine_out = options.machine_out;
  const bool is_positioning =
      !imported.header.campaigns.empty() &&
      imported.header.campaigns.begin()->second.plan == "iso230";
  // Rows of motors say nothing without their machine.
  const bool wants_machine = machine_out.empty() && !imported.machine_yaml.empty();
  if (out.empty()) {
    std::cout << fmt::format(
        "next:      nothing was written; the same with --out DATA.csv{} writes the "
        "rows\n",
        wants_machine ? " --machine-out M.yaml" : "");
    return;
  }
  std::cout << fmt::format(
      "next:      {}caltwin diagnose {}{}{}\n",
      wants_machine ? "the same with --machine-out M.yaml, then " : "",
      out,
      wants_machine         ? " --machine M.yaml"
      : machine_out.empty() ? ""
                            : " --machine " + machine_out,
      is_positioning ? fmt::format(", caltwin iso230 {}", out) : "");
}

void RefuseMissing(const ImportAsked& options, const Imported& imported) {
  if (!options.machine_out.empty() && imported.machine_yaml.empty()) {
    throw InputError(
        {.file = "--machine-out"},
        fmt::format("a file of the kind {} says nothing of the machine", options.kind),
        "caltwin new machine NAME writes a file to begin with");
  }
  if (!options.out.empty() && imported.table.rows.empty()) {
    throw InputError(
        {.file = "--out"},
        fmt::format("a file of the kind {} measures nothing: there are no rows",
                    options.kind),
        "--machine-out M.yaml writes the machine that it describes");
  }
}

void PrintFound(const Imported& imported) {
  Print("recognised", imported.recognised);
  Print("assumed", imported.assumed);
  Print("warning", imported.warnings);
}

/// Of a file that describes a machine and measures nothing.
void WriteMachineAlone(const ImportAsked& options, const Imported& imported) {
  if (options.machine_out.empty()) {
    std::cout << imported.machine_yaml;
    return;
  }
  WriteTextFile(options.machine_out, imported.machine_yaml);
  std::cout << fmt::format(
      "{}: a machine, from {}\n", options.machine_out, options.file);
  PrintFound(imported);
}

/// Rows and their header where `--out` names them, the machine where `--machine-out`
/// does; what is not asked for is not written.
void WriteAskedFor(const ImportAsked& options, const Imported& imported) {
  const fs::path header = fs::path(options.out).replace_extension(".yaml");
  if (!options.out.empty()) {
    WriteDataHeader(header, imported.header);
  }
  if (!options.machine_out.empty()) {
    WriteTextFile(options.machine_out, imported.machine_yaml);
  }
  if (!options.out.empty()) WriteRows(options.out, imported.table);
}

int RunImport(ImportAsked options) {
  ImportOptions import = options.import;
  if (options.step_mm > 0) import.step_mm = options.step_mm;
  RefuseOverwriting({{"the file", options.file}},
                    Together({RowsAndHeader("--out", options.out),
                              {{"--machine-out", options.machine_out}}}));
  const std::string text = ReadTextFile(options.file, kLargestData_bytes);
  options.kind = KindOrFound(options.kind, text, options.file);
  if (options.kind == "rows") {
    throw InputError({.file = options.file},
                     "measured rows already: there is nothing to import",
                     fmt::format("caltwin diagnose {}", options.file));
  }
  const Imported imported = ImportText(options.kind, text, options.file, import);
  RefuseMissing(options, imported);
  if (imported.table.rows.empty()) {
    WriteMachineAlone(options, imported);
    return kPassed;
  }
  const std::vector<Doubt> doubts =
      Doubts(imported.table,
             imported.header,
             nullptr,
             {.has_unit = imported.has_unit, .is_deviation = imported.is_deviation});
  RefuseImplausible(doubts, options.file);
  const std::vector<std::string> account =
      ImportAccount(options.kind, text, options.file, import);
  WriteAskedFor(options, imported);
  std::cout << (options.out.empty()
                    ? fmt::format(
                          "{}: {} rows\n", options.file, imported.table.rows.size())
                    : fmt::format("{}: {} rows from {}\n",
                                  options.out,
                                  imported.table.rows.size(),
                                  options.file));
  PrintFound(imported);
  Print("finds", account);
  for (const Doubt& doubt : doubts) {
    Print("note", {doubt.message});
    if (!doubt.hint.empty()) Print("", {doubt.hint});
  }
  PrintNext(imported, options);
  return kPassed;
}

}  // namespace

Action DeclareImport(CLI::App* app) {
  const auto options = std::make_shared<ImportAsked>();
  std::string kinds;
  for (const Importer& importer : AllImporters()) {
    kinds += fmt::format("  {:<16}{}\n", importer.kind, importer.about);
  }
  app->add_option("KIND FILE",
                  options->words,
                  "the file to read; before it what it is (below), where that is not "
                  "found by its text")
      ->required()
      ->expected(1, 2);
  app->add_option(
      "--out",
      options->out,
      "write measured rows, DATA.csv (and DATA.yaml); without it nothing is written");
  app->add_option("--machine-out",
                  options->machine_out,
                  "a machine file, where the file knows one");
  app->add_option("--map",
                  options->import.map,
                  "which column is which: value_mm=dev[um],cmd_x_mm=1,campaign:=laser")
      ->allow_extra_args(false);
  app->add_option(
      "--axis", options->import.axis, "x, y or z, where the file is silent");
  app->add_option(
      "--unit", options->import.unit, "of the readings, where it is silent");
  app->add_option("--campaign", options->import.campaign, "a name for the campaign");
  app->add_option("--step-mm", options->step_mm, "the true length of a motor step")
      ->check(CLI::Range(1e-7, 1.0));
  app->footer("Kinds:\n" + kinds);
  return [options] {
    options->file = options->words.back();
    options->kind = options->words.size() == 2 ? options->words.front() : "";
    return RunImport(*options);
  };
}

}  // namespace caltwin

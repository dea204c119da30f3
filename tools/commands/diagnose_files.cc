#include "tools/commands/diagnose_files.h"

#include <algorithm>
#include <iostream>
#include <utility>

#include <fmt/format.h>

#include "calibration/diagnosis/changes_json.h"
#include "calibration/diagnosis/diagnosis_json.h"
#include "calibration/diagnosis/diagnosis_summary.h"
#include "calibration/diagnosis/errors_by_place.h"
#include "calibration/diagnosis/extension.h"
#include "calibration/diagnosis/kinds/diagnosed_kind.h"
#include "calibration/diagnosis/pictures_json.h"
#include "renders/diagnosis_report.h"
#include "sim/base/sha256.h"
#include "sim/base/text_file.h"
#include "tools/commands/command.h"
#include "tools/commands/starter.h"

namespace caltwin {

namespace fs = std::filesystem;

std::string Sha256OfFile(const fs::path& file) {
  return file.empty() ? "" : Sha256(ReadTextFile(file, kLargestData_bytes));
}

std::string CommandOf(const DiagnoseAsked& options) {
  std::string command = "caltwin diagnose";
  if (!options.file.empty()) command += " " + options.file;
  if (!options.machine.empty()) command += " --machine " + options.machine;
  if (!options.before.empty()) command += " --before " + options.before;
  if (!options.closed_loop.empty()) {
    command += " --closed-loop '" + options.closed_loop + "'";
  }
  if (options.min_effect_um > 0) {
    command += fmt::format(" --min-effect-um {:g}", options.min_effect_um);
  }
  if (options.seed != 1) command += fmt::format(" --seed {}", options.seed);
  return command;
}

namespace {

// How the extension names what it extends: a name as given, a file from its own folder.
std::string ExtendsOf(const DiagnoseAsked& options, const fs::path& machine) {
  const std::string& given = options.machine;
  const bool is_name = !given.empty() && given.find('/') == std::string::npos &&
                       !given.ends_with(".yaml");
  if (is_name) return given;
  const fs::path folder = fs::absolute(options.extend).lexically_normal().parent_path();
  return fs::absolute(machine).lexically_normal().lexically_proximate(folder).string();
}

// What pictures can show: findings that a model was fitted to.
Diagnosis OfModel(Diagnosis diagnosis) {
  std::erase_if(diagnosis.findings,
                [](const Finding& finding) { return finding.is_of_facts; });
  return diagnosis;
}

}  // namespace

fs::path FileOfAssumed(const DiagnoseAsked& options) {
  if (options.extend.empty()) return {};
  fs::path stem = fs::path(options.extend).replace_extension();
  if (stem.extension() == ".ext") stem.replace_extension();
  return stem += ".machine.yaml";
}

std::string WriteExtension(const DiagnoseAsked& options,
                           const Believed& believed,
                           const Diagnosis& diagnosis) {
  if (options.extend.empty()) return "";
  if (diagnosis.findings.empty()) {
    if (options.json != "-") {
      std::cout << fmt::format("{}: not written, nothing was found to extend with.\n",
                               options.extend);
    }
    return "";
  }
  fs::path machine = believed.file;
  if (machine.empty()) {
    machine = FileOfAssumed(options);
    WriteTextFile(machine, StarterText(believed.machine, "assumed"));
    if (options.json != "-") {
      std::cout << fmt::format(
          "{} extends {}, the machine as it was assumed. Put your own sizes there and "
          "diagnose again with --machine.\n",
          options.extend,
          machine.string());
    }
  }
  WriteTextFile(options.extend,
                ExtensionText(diagnosis,
                              {.extends = ExtendsOf(options, machine),
                               .extends_sha256 = Sha256OfFile(machine),
                               .data_sha256 = Sha256OfFile(options.file)}));
  return options.extend;
}

void WriteCorrection(const DiagnoseAsked& options, const Judged& judged) {
  if (options.correction.empty()) return;
  const std::string name = fs::path(options.correction).filename().string();
  for (const CorrectionFile& file : CorrectionFor(ControllerNamed(options.controller),
                                                  judged.diagnosis,
                                                  judged.observed,
                                                  name)) {
    WriteTextFile(options.correction + file.suffix, file.text);
  }
}

void WriteJson(const DiagnoseAsked& options,
               const Believed& believed,
               const Judged& judged,
               const TextNotes& text_notes,
               const std::string& extended) {
  nlohmann::ordered_json tree = ToJson(judged.diagnosis,
                                       extended,
                                       {.data_sha256 = Sha256OfFile(options.file),
                                        .machine_sha256 = Sha256OfFile(believed.file),
                                        .version = CALTWIN_VERSION,
                                        .seed = options.seed,
                                        .command = CommandOf(options)});
  tree["summary"] = SummaryJson(SummaryOf(judged.diagnosis, text_notes));
  tree["gain"]["volumetric"] = VolumetricJson(judged.volumetric);
  tree["replay"] = ReplayJson(judged.replay);
  if (!options.closed_loop.empty()) tree["rounds"] = RoundsJson(judged.rounds);
  const Diagnosis fitted = OfModel(judged.diagnosis);
  tree["show"] = ShowJson(PicturesDataOf(judged.observed, fitted));
  tree["show"]["places_of"] = fitted.findings.empty() ? "baseline" : "findings";
  tree["show"]["places"] = ToJson(ErrorsByPlace(judged.observed, fitted));
  if (text_notes.has_before) tree["changes"] = ChangesJson(text_notes.changes);
  const std::string json = tree.dump(kJsonIndent) + "\n";
  if (options.json == "-") {
    std::cout << json;
  } else {
    WriteTextFile(options.json, json);
  }
}

void WriteReportOf(const DiagnoseAsked& options,
                   const Judged& judged,
                   const TextNotes& text_notes) {
  if (options.report.empty()) return;
  WriteDiagnosisReport(
      judged.diagnosis,
      PicturesDataOf(judged.observed, OfModel(judged.diagnosis)),
      {.data = options.file,
       .text = DiagnosisText(judged.diagnosis, text_notes) + "\n" +
               VolumetricText(judged.volumetric) + ReplayText(judged.replay),
       .words = text_notes,
       .command = CommandOf(options),
       .folder = options.report,
       .version = CALTWIN_VERSION,
       .seed = options.seed},
      options.report);
}

}  // namespace caltwin

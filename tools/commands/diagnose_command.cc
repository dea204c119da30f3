#include <algorithm>
#include <filesystem>
#include <iostream>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "calibration/diagnosis/changes_json.h"
#include "calibration/diagnosis/closed_loop.h"
#include "calibration/diagnosis/diagnosis.h"
#include "calibration/diagnosis/diagnosis_json.h"
#include "calibration/diagnosis/diagnosis_summary.h"
#include "calibration/diagnosis/diagnosis_text.h"
#include "calibration/diagnosis/errors_by_place.h"
#include "calibration/diagnosis/extension.h"
#include "calibration/diagnosis/kinds/diagnosed_kind.h"
#include "calibration/diagnosis/name_by_facts.h"
#include "calibration/diagnosis/pictures_json.h"
#include "calibration/diagnosis/replay.h"
#include "calibration/diagnosis/screw_table.h"
#include "calibration/diagnosis/volumetric.h"
#include "renders/diagnosis_report.h"
#include "scenarios/interrupt.h"
#include "sim/base/sha256.h"
#include "sim/base/text_file.h"
#include "tools/commands/believed_machine.h"
#include "tools/commands/closed_loop.h"
#include "tools/commands/command.h"
#include "tools/commands/diagnose_files.h"
#include "tools/commands/measured_data.h"
#include "tools/commands/progress.h"
#include "tools/commands/spare_files.h"
#include "tools/commands/starter.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;

Judged Judge(const Data& data, const Believed& believed, const DiagnoseAsked& options) {
  ProgressLine progress;
  Judged judged{.observed = Observed(data.table,
                                     data.header,
                                     believed.machine,
                                     DrawEffects(believed.effects, options.seed, 0))};
  judged.diagnosis =
      Diagnose(judged.observed,
               {.search = {.seed = options.seed},
                .min_effect_um = options.min_effect_um,
                .progress = [&](const std::string& text) { progress.Show(text); },
                .levelling = data.levelling,
                .has_places = data.has_places,
                .has_machine = data.told_kind.empty() || !believed.file.empty()});
  return judged;
}

// What physics says to the diagnosis, and what it is worth at poses nobody measured.
void TryInTwin(const DiagnoseAsked& options, Judged* judged) {
  judged->volumetric =
      VolumetricGainOf(judged->observed, judged->diagnosis, options.seed);
  if (options.replay == "none") {
    judged->replay.why_not = "Not replayed in MuJoCo, as told (--replay none).";
    return;
  }
  ReplayOptions how{.interrupted = InterruptRequested};
  if (options.must_replay) how.most_rows = std::numeric_limits<int>::max();
  judged->replay = ReplayOf(judged->observed, judged->diagnosis, how);
}

// Begins with the rows at hand and measures on until one cause is left.
Judged JudgeInLoop(const MachineUnderTest& tested,
                   const Believed& believed,
                   const DiagnoseAsked& options,
                   Data* data) {
  ProgressLine progress;
  const auto tell = [&](const LoopRound& round) {
    progress.Clear();
    if (options.json != "-") std::cout << RoundText(round) << '\n' << std::flush;
  };
  ClosedLoop loop =
      MeasureUntilSettled({data->table, WithUsualInstruments(data->header)},
                          believed.machine,
                          DrawEffects(believed.effects, options.seed, 0),
                          tested.measure,
                          {.seed = options.seed,
                           .settings = tested.settings,
                           .diagnose = {.search = {.seed = options.seed},
                                        .min_effect_um = options.min_effect_um,
                                        .progress =
                                            [&](const std::string& text) {
                                              progress.Show(text);
                                            }},
                           .told = tell});
  progress.Clear();
  if (options.json != "-") std::cout << "\n";
  if (!options.record.empty()) Record(options.record, believed.file, loop.session);
  data->table = std::move(loop.session.table);
  data->header = std::move(loop.session.header);
  return {.observed = std::move(loop.observed),
          .diagnosis = std::move(loop.diagnosis),
          .rounds = std::move(loop.rounds)};
}

// The earlier campaign under the same machine; what it is has its own notes.
std::vector<Change> Compare(const DiagnoseAsked& options,
                            const Believed& believed,
                            const Judged& now,
                            std::vector<std::string>* notes) {
  Data earlier = ReadData(options.before);
  JudgeData(options.before, nullptr, &earlier);
  for (const std::string& note : earlier.notes) {
    notes->push_back(options.before + ": " + note);
  }
  const Judged before = Judge(earlier, believed, options);
  return ChangesSince({before.observed, before.diagnosis},
                      {now.observed, now.diagnosis});
}

// Of a closed loop; the machine it is told by is believed where nothing else is said.
std::optional<MachineUnderTest> Tested(DiagnoseAsked* options, const Data& data) {
  if (options->closed_loop.empty()) return std::nullopt;
  MachineUnderTest tested = MachineAt(options->closed_loop);
  if (options->machine.empty() && data.header.machine.empty()) {
    options->machine = tested.machine;
  }
  return tested;
}

void RequireSettings(const DiagnoseAsked& options, const Machine& machine) {
  if (options.correction.empty()) return;
  const ControllerKind controller = ControllerNamed(options.controller);
  DiagnosedAs(machine).RequireSettings(controller);
}

// No steps/mm are written that nobody stated: those of a machine that is only assumed.
void RequireStatedSteps(const DiagnoseAsked& options,
                        const Data& data,
                        const Judged& judged) {
  if (options.correction.empty()) return;
  for (const Axis axis : AxesOfNewSteps(judged.diagnosis, judged.observed)) {
    const bool is_stated = std::ranges::any_of(
        data.header.settings,
        [&](const auto& one) { return one.second.steps_per_mm.contains(Name(axis)); });
    if (is_stated) continue;
    throw InputError(
        {.file = "--correction"},
        fmt::format(
            "the steps/mm of {} are off, and nobody says which are set, so none "
            "can be corrected",
            CapitalLetter(axis)),
        fmt::format(
            "say them in {}: settings: {{s1: {{steps_per_mm: {{{}: 80}}}}}}, or "
            "name the machine (--machine). Without --correction the answer says "
            "by which factor they are off",
            fs::path(options.file).replace_extension(".yaml").filename().string(),
            Name(axis)));
  }
}

void CheckSparesOfDiagnose(const DiagnoseAsked& options, const Believed& believed) {
  const fs::path assumed = FileOfAssumed(options);
  if (believed.file.empty() && fs::exists(assumed)) {
    throw InputError({.file = assumed.string()},
                     "is there already: --extend would put the assumed machine there",
                     "believe it (--machine), or give the extension another name");
  }
  std::vector<NamedFile> corrections = {{"--correction", options.correction}};
  for (const Axis axis : kAxes) {
    if (options.correction.empty()) continue;
    corrections.push_back(
        {"--correction", options.correction + ScrewTableSuffix(axis)});
  }
  RefuseOverwriting(
      Together({RowsAndHeader("the data", options.file),
                RowsAndHeader("the earlier data", options.before),
                FilesOf(believed.machine),
                LinkFiles(options.closed_loop)}),
      Together({{{"--extend", options.extend},
                 {"--extend", believed.file.empty() ? FileOfAssumed(options) : ""},
                 {"--json", options.json},
                 {"--report", options.report, /*is_folder=*/true}},
                corrections,
                RowsAndHeader("--record", options.record)}));
}

// The figures of a note.
std::optional<Fact> FactOf(const FileNote& note) {
  if (note.fact.empty()) return std::nullopt;
  Fact fact{.id = note.fact,
            .axis = note.axis,
            .word = note.word,
            .sentence = note.sentence,
            .is_answer = true};
  for (const NoteFigure& figure : note.figures)
    fact.figures.push_back({figure.key, figure.value, figure.sd});
  fact.cause = note.cause;
  fact.cause_axis = note.axis;
  for (const NoteFigure& figure : note.parameters)
    fact.parameters.push_back({figure.key, figure.value, figure.sd});
  return fact;
}

// Of a machine that is no gantry, what is said of gantries: the file's own fact goes
// before one of that name, and its own advice before all.
void LeaveOutGantries(const Data& data, Facts* facts) {
  if (data.told_kind.empty()) return;
  std::erase_if(facts->all, [&](const Fact& fact) {
    return std::ranges::find(data.story, fact.id, &FileNote::fact) != data.story.end();
  });
  if (!data.next_sentence.empty()) facts->next.clear();
}

// What a file says beyond its readings, as facts.
void AddStory(const Data& data, Facts* facts) {
  LeaveOutGantries(data, facts);
  std::vector<Fact> found;
  bool is_told = false;
  for (const FileNote& note : data.story) {
    if (note.kind == FileNote::Kind::kOpen) {
      facts->not_determined.push_back(note.what);
      facts->cannot.push_back(note.sentence);
      continue;
    }
    if (auto fact = FactOf(note)) found.push_back(std::move(*fact));
    if (note.kind == FileNote::Kind::kFact) continue;
    const bool is_setting = note.kind == FileNote::Kind::kSetting;
    // What the file itself says goes before what a ratio suggests.
    if (!is_told) {
      is_told = true;
      facts->not_the_machine = {is_setting ? "settings" : note.what, note.sentence};
    }
    if (!is_setting) continue;
    found.push_back({.id = "settings",
                     .word = note.what,
                     .figures = {{"line", static_cast<double>(note.place.line)}},
                     .sentence = note.sentence,
                     .is_answer = true});
  }
  facts->all.insert(facts->all.begin(), found.begin(), found.end());
  if (!data.next_instrument.empty()) {
    facts->next.insert(
        facts->next.begin(),
        {data.next_instrument,
         data.next_sentence.empty() ? "measure that with a " + data.next_instrument
                                    : data.next_sentence});
  }
}

// A file that describes a machine and measures nothing.
int TellSettings(const DiagnoseAsked& options, const Data& data) {
  Diagnosis diagnosis{.remarks = data.notes, .has_model = false};
  AddStory(data, &diagnosis.facts);
  const bool is_named = std::ranges::any_of(
      data.story, [](const FileNote& note) { return !note.cause.empty(); });
  if (is_named) NameByFacts(&diagnosis);
  if (data.story.empty()) {
    throw InputError(
        {.file = options.file},
        "describes a machine and measures nothing, and no setting in it "
        "contradicts another",
        "add what was measured: touched heights, commanded and read positions; "
        "caltwin import FILE --machine-out M.yaml writes the machine");
  }
  if (options.json != "-") std::cout << DiagnosisText(diagnosis, {});
  if (options.json.empty()) return kPassed;
  nlohmann::ordered_json tree = ToJson(diagnosis,
                                       "",
                                       {.data_sha256 = Sha256OfFile(options.file),
                                        .version = CALTWIN_VERSION,
                                        .seed = options.seed,
                                        .command = CommandOf(options)});
  tree["summary"] = SummaryJson(SummaryOf(diagnosis, {}));
  const std::string json = tree.dump(kJsonIndent) + "\n";
  if (options.json == "-") {
    std::cout << json;
  } else {
    WriteTextFile(options.json, json);
  }
  return kPassed;
}

int RunDiagnose(DiagnoseAsked options) {
  CheckLoop(options.file, options.closed_loop, options.record);
  Data data;
  if (options.step_mm > 0) options.import.step_mm = options.step_mm;
  options.import.has_machine = !options.machine.empty();
  if (!options.file.empty()) data = ReadData(options.file, options.import);
  if (!options.file.empty() && data.table.rows.empty())
    return TellSettings(options, data);
  const auto tested = Tested(&options, data);
  const Believed believed = BelievedMachine(options.file, options.machine, &data);
  RequireSettings(options, believed.machine);
  CheckSparesOfDiagnose(options, believed);
  if (!options.file.empty()) {
    JudgeData(options.file, believed.file.empty() ? nullptr : &believed.machine, &data);
  }
  Judged judged = tested ? JudgeInLoop(*tested, believed, options, &data)
                         : Judge(data, believed, options);
  if (believed.file.empty()) RequireStatedSteps(options, data, judged);
  AddStory(data, &judged.diagnosis.facts);
  const bool is_of_facts =
      std::ranges::any_of(judged.diagnosis.findings, &Finding::is_of_facts);
  const bool is_replayed = judged.diagnosis.has_model && !is_of_facts;
  if (is_replayed) TryInTwin(options, &judged);
  TextNotes notes{.measured = WhatRowsMeasure(data.table),
                  .has_before = !options.before.empty()};
  if (notes.has_before) {
    notes.changes = Compare(options, believed, judged, &data.notes);
  }
  auto& remarks = judged.diagnosis.remarks;
  remarks.insert(remarks.begin(), data.notes.begin(), data.notes.end());
  if (judged.diagnosis.verdict == DiagnosisVerdict::kNone &&
      judged.diagnosis.has_model) {
    notes.would_show = WhatRowsWouldShow(judged.observed, judged.diagnosis);
  }
  if (options.json != "-") {
    std::cout << DiagnosisText(judged.diagnosis, notes) << "\n"
              << VolumetricText(judged.volumetric)
              << (is_replayed ? ReplayText(judged.replay) : "");
  }
  const std::string extended = WriteExtension(options, believed, judged.diagnosis);
  WriteCorrection(options, judged);
  WriteReportOf(options, judged, notes);
  if (!options.json.empty()) WriteJson(options, believed, judged, notes, extended);
  return kPassed;
}

}  // namespace

Action DeclareDiagnose(CLI::App* app) {
  const auto options = std::make_shared<DiagnoseAsked>();
  app->add_option("data",
                  options->file,
                  "measured rows (DATA.csv), or any file that caltwin import reads: a "
                  "console log, a table, a height map, a printer.cfg");
  app->add_option("--unit",
                  options->import.unit,
                  "of the readings, where the file does not say: mm um inch thou");
  app->add_option(
      "--axis", options->import.axis, "measured, where the file does not say: x y z");
  app->add_option("--map",
                  options->import.map,
                  "which column of a table is which (caltwin import csv)")
      ->allow_extra_args(false);
  app->add_option("--step-mm", options->step_mm, "the true length of a motor step")
      ->check(CLI::Range(1e-7, 1.0));
  app->add_option(
      "--machine", options->machine, "a name, a machine file, or an extension");
  app->add_option(
      "--json", options->json, "write the diagnosis as JSON; - for stdout alone");
  app->add_option("--report", options->report, "write an HTML report to this folder");
  app->add_option("--extend", options->extend, "write the extended machine");
  app->add_option("--before", options->before, "earlier rows: tell what changed since");
  CLI::Option* controller =
      app->add_option("--for", options->controller, "the controller to correct")
          ->check(CLI::IsMember({"rrf", "klipper", "marlin", "linuxcnc"}));
  app->add_option("--correction",
                  options->correction,
                  "write the controller's settings that mend what was found")
      ->needs(controller);
  app->add_option("--min-effect-um",
                  options->min_effect_um,
                  "smaller effects are of no interest")
      ->check(CLI::Range(0.0, 1e6));
  app->add_option("--seed", options->seed, "of the bootstrap");
  CLI::Option* closed_loop = app->add_option(
      "--closed-loop",
      options->closed_loop,
      "measure what is asked for on twin:M.yaml?truth=T.yaml until one cause is left, "
      "beginning with the rows given, if any");
  app->add_option("--record", options->record, "write all rows measured, with header")
      ->needs(closed_loop);
  const CLI::Option* replay =
      app->add_option("--replay",
                      options->replay,
                      "physics: take the rows again in MuJoCo, with what was found "
                      "(left alone beyond 3000 rows unless told); none: do not")
          ->check(CLI::IsMember({"physics", "none"}))
          ->capture_default_str();
  return [options, replay] {
    options->must_replay = replay->count() > 0;
    return RunDiagnose(*options);
  };
}

}  // namespace caltwin

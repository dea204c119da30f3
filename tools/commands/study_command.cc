#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "renders/study_report.h"
#include "scenarios/interrupt.h"
#include "scenarios/result_text.h"
#include "scenarios/study/adaptive.h"
#include "scenarios/study/best_readings.h"
#include "scenarios/study/budget.h"
#include "scenarios/study/linear.h"
#include "scenarios/study/merge.h"
#include "scenarios/study/run.h"
#include "scenarios/study/summary.h"
#include "scenarios/study/trials_csv.h"
#include "scenarios/study/unkept.h"
#include "sim/base/text_file.h"
#include "tools/commands/command.h"
#include "tools/commands/progress.h"
#include "tools/commands/spare_files.h"
#include "tools/commands/study_progress.h"
#include "tools/commands/study_trial.h"

namespace caltwin {

namespace fs = std::filesystem;

namespace {

constexpr int kMostWorkers = 1024;
constexpr std::size_t kLargestSummary_bytes = 100'000'000;

struct StudyAsked {
  std::string study{};
  std::string out{};
  std::string report{};
  int workers = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  bool resume = false;
  bool tells_progress = false;
  std::optional<std::int64_t> trial{};
  std::string shard{};
  std::vector<std::string> merge{};
};

// Of the whole study: "next_study" beside where one is.
fs::path FolderOfStudy(const StudyAsked& options) {
  return options.out.empty() ? fs::path(options.study).stem() : fs::path(options.out);
}

// What says the same already is left alone, its time of writing too.
void WriteIfOther(const fs::path& file, const std::string& text) {
  std::error_code error;
  if (fs::is_regular_file(file, error) && fs::file_size(file, error) == text.size() &&
      ReadTextFile(file, text.size()) == text) {
    return;
  }
  WriteTextFile(file, text);
}

// Whether the folder holds what came out of this study; throws InputError where that
// is another's.
bool HoldsSummary(const Study& study, const fs::path& folder) {
  const fs::path file = folder / "summary.json";
  std::error_code error;
  if (!fs::exists(file, error)) return false;
  const auto json = nlohmann::json::parse(ReadTextFile(file, kLargestSummary_bytes),
                                          nullptr,
                                          /*allow_exceptions=*/false);
  if (json.is_object() && json.value("fingerprint", nlohmann::json()) ==
                              nlohmann::json(study.Fingerprint())) {
    return true;
  }
  throw InputError(
      {.file = file.string()},
      "is of another study, or of this one before its files or the program "
      "changed",
      "choose another folder with --out");
}

// Aggregates leave a summary alone, and no folder that holds trials is theirs.
bool IsDone(const Study& study, const fs::path& folder) {
  const fs::path trials = folder / "study.sqlite";
  std::error_code error;
  if (fs::exists(trials, error)) {
    throw InputError({.file = trials.string()},
                     "holds the trials of another study, and this one keeps none",
                     "choose another folder with --out");
  }
  return HoldsSummary(study, folder);
}

// Says and writes what came out; `files` is what else lies in the folder.
int Tell(const Study& study,
         const StudyAsked& options,
         const StudyFindings& findings,
         const std::string& files) {
  const fs::path folder = FolderOfStudy(options);
  WriteIfOther(folder / "summary.json",
               SummaryJson(study, findings.summary).dump(kJsonIndent) + "\n");
  std::cout << SummaryText(study, findings.summary);
  for (std::size_t i = 0; i < findings.budgets.size(); ++i) {
    std::cout << BudgetText(study.cases[i].Name(), findings.budgets[i]);
  }
  if (study.plan) std::cout << WorthText(*study.plan, WorthOf(*study.plan));
  std::cout << findings.remarks
            << fmt::format("\n{}: {}summary.json\n", folder.string(), files);
  if (options.report.empty()) return kPassed;
  WriteStudyReport(study, findings, options.report);
  std::cout << fmt::format("{}: index.html and its pictures\n", options.report);
  return kPassed;
}

// Whether linear is good enough, which the first part (or the whole) finds out for all:
// throws InputError where it is not, else says and keeps how good.
std::string CheckedLinear(const Study& study,
                          const StudyAsked& options,
                          const StudyOptions& how) {
  if (!study.is_linear || how.shard.index != 0) return "";
  const LinearCheck check = CheckLinear(study, how);
  if (InterruptRequested()) return "";
  RequireLinear(study, check);
  WriteIfOther(FolderOfStudy(options) / "linear_check.json",
               ToJson(check).dump(kJsonIndent) + "\n");
  return CheckText(check);
}

int SumUp(const Study& study,
          const StudyAsked& options,
          const StudyStore& store,
          const std::string& remarks) {
  WriteTrialsCsv(study, store, FolderOfStudy(options) / "trials.csv");
  return Tell(study,
              options,
              {.summary = SummaryOf(study, store),
               .budgets = BudgetsOf(study, store),
               .remarks = remarks},
              "trials.csv, study.sqlite, ");
}

// A line that says how far it is, while one of these lives.
struct Shown {
  StudyOptions With(const StudyAsked& options) {
    return {.workers = options.workers,
            .shard = options.shard.empty() ? Shard{} : ReadShard(options.shard),
            .progress = [this, &options](const StudyProgress& now) {
              line.Show(ProgressText(now));
              if (options.tells_progress)
                std::cout << ProgressJson(now) << '\n' << std::flush;
            }};
  }
  ProgressLine line{};
};

// What the folder holds as this part (or the whole: 1/1); throws InputError where it
// holds another part, or trials.
struct HeldUnkept {
  std::optional<Aggregates> part{};
  bool is_done = false;
};
HeldUnkept HeldIn(const fs::path& folder, const Study& study, const Shard& shard) {
  HeldUnkept held{.is_done = IsDone(study, folder)};
  auto part = ReadPart(study, folder);
  const std::string text = part ? part->shard.Text() : Shard{}.Text();
  if ((part || held.is_done) && text != shard.Text()) {
    throw InputError(
        {.file = folder.string()},
        fmt::format("holds part {} of the study, not {}", text, shard.Text()),
        "choose another folder with --out");
  }
  if (part) held.part = std::move(part->aggregates);
  return held;
}

int SumUpUnkept(const Study& study,
                const StudyAsked& options,
                const Aggregates& aggregates,
                const std::string& remarks,
                const std::string& files) {
  return Tell(study,
              options,
              {.summary = SummaryOf(study, aggregates), .remarks = remarks},
              files);
}

constexpr const char* kPartFiles = "aggregates.json, ";

// What `act` refuses leaves nothing new behind.
template <typename Act>
void OrDiscard(StudyStore* store, const Act& act) {
  try {
    act();
  } catch (const InputError&) {
    store->DiscardIfEmpty();
    throw;
  }
}

void SayStopped(std::int64_t done, std::int64_t all, const fs::path& folder) {
  std::cerr << fmt::format("{} of {} runs are kept in {}; --resume goes on with them\n",
                           done,
                           all,
                           folder.string());
}

std::int64_t RunsOf(const Study& study, const Shard& shard) {
  return shard.NumOf(study.trials) * static_cast<std::int64_t>(study.cases.size());
}

// With --resume, of a study or part that is finished.
int TellFinished(const Study& study,
                 const StudyAsked& options,
                 const HeldUnkept& held) {
  if (std::error_code error;
      fs::exists(FolderOfStudy(options) / StudyStore::kUnfinished, error)) {
    // Killed before it was taken away.
    const Shard shard = options.shard.empty() ? Shard{} : ReadShard(options.shard);
    StudyStore(FolderOfStudy(options), study, /*may_resume=*/true, shard).Discard();
  }
  if (held.part) return SumUpUnkept(study, options, *held.part, "", kPartFiles);
  std::cout << fmt::format("{}: finished; summary.json is as it was\n",
                           FolderOfStudy(options).string());
  return kPassed;
}

// Aggregates alone.
int RunAggregates(const Study& study, const StudyAsked& options) {
  const fs::path folder = FolderOfStudy(options);
  Shown shown;
  const StudyOptions how = shown.With(options);
  const HeldUnkept held = HeldIn(folder, study, how.shard);
  if (options.resume && (held.part || held.is_done)) {
    return TellFinished(study, options, held);
  }
  StudyStore store(folder, study, options.resume, how.shard);
  MakeWritable(folder, /*is_to_be_read=*/false);
  std::string remarks;
  OrDiscard(&store, [&] { remarks = CheckedLinear(study, options, how); });
  const Aggregates aggregates = RunUnkept(study, how, &store);
  shown.line.Clear();
  if (InterruptRequested()) {
    std::int64_t done = 0;
    for (const Aggregate& one : aggregates) done += one.trials();
    SayStopped(done, RunsOf(study, how.shard), folder);
    return kInterrupted;
  }
  std::string files;
  if (!options.shard.empty()) {
    WritePart(study, how.shard, aggregates, folder);
    files = kPartFiles;
  }
  const int exit_code = SumUpUnkept(study, options, aggregates, remarks, files);
  store.Discard();
  return exit_code;
}

int MergeAggregates(const Study& study, const StudyAsked& options) {
  const HeldUnkept held = HeldIn(FolderOfStudy(options), study, Shard{});
  if (options.resume && held.is_done) return TellFinished(study, options, held);
  const Aggregates whole =
      MergeUnkept(study, {options.merge.begin(), options.merge.end()});
  return SumUpUnkept(study, options, whole, "", "");
}

int Merge(const Study& study, const StudyAsked& options) {
  const fs::path folder = FolderOfStudy(options);
  StudyStore whole(folder, study, options.resume);
  OrDiscard(&whole, [&] {
    HoldsSummary(study, folder);
    MergeParts(study, {options.merge.begin(), options.merge.end()}, &whole);
  });
  return SumUp(study, options, whole, "");
}

void CheckSparesOfStudy(const Study& study, const StudyAsked& options) {
  std::vector<NamedFile> read = {{"the study", study.file}};
  for (const auto& one : study.cases) {
    read.push_back({"a scenario", one.scenario.file});
    read = Together({read, FilesOf(one.scenario.machine.machine)});
  }
  const fs::path folder = FolderOfStudy(options);
  RefuseOverwriting(read, {{"--out", folder, /*is_folder=*/true}});
  RefuseOverwriting(read,
                    {{"--out", folder / "summary.json"},
                     {"--out", folder / "trials.csv"},
                     {"--out", folder / "linear_check.json"},
                     {"--out", folder / "study.sqlite"},
                     {"--out", folder / StudyStore::kUnfinished},
                     {"--report", options.report, /*is_folder=*/true}});
}

int RunStudy(const StudyAsked& options) {
  Study study = ReadStudy(options.study);
  CheckSparesOfStudy(study, options);
  if (options.trial) {
    return ReplayTrial(study, *options.trial, options.report);
  }
  if (!options.merge.empty()) {
    return study.keeps_trials ? Merge(study, options) : MergeAggregates(study, options);
  }
  if (study.adaptive_digits > 0 && !options.shard.empty()) {
    throw InputError({.file = study.file.string()},
                     "is adaptive: how many trials it takes is known at the end alone",
                     "parts need a fixed number: write `trials: N`");
  }
  if (!study.keeps_trials) return RunAggregates(study, options);
  const fs::path folder = FolderOfStudy(options);
  Shown shown;
  const StudyOptions how = shown.With(options);
  StudyStore store(folder, study, options.resume, how.shard);
  const auto done = static_cast<std::int64_t>(store.Done().size());
  // Only what is finished is summed up in a read-only folder.
  MakeWritable(folder, study.adaptive_digits > 0 || done >= RunsOf(study, how.shard));
  std::string remarks;
  OrDiscard(&store, [&] {
    HoldsSummary(study, folder);
    // Was good enough when it was begun.
    if (done == 0) remarks = CheckedLinear(study, options, how);
  });
  AdaptiveStop stop(study.adaptive_digits);
  const StudyProgress progress = study.adaptive_digits > 0
                                     ? RunAdaptive(&study, how, &store, &stop)
                                     : RunStudy(study, how, &store);
  shown.line.Clear();
  if (InterruptRequested()) {
    SayStopped(progress.done, progress.all, folder);
    return kInterrupted;
  }
  if (study.adaptive_digits > 0) remarks += SettlingText(stop);
  return SumUp(study, options, store, remarks);
}

}  // namespace

Action DeclareStudy(CLI::App* app) {
  const auto options = std::make_shared<StudyAsked>();
  app->add_option("STUDY", options->study, "what to draw and compare (docs/studies.md)")
      ->required();
  app->add_option("--out", options->out, "folder; default: named after the study");
  app->add_option(
      "--report",
      options->report,
      "folder for an HTML report: coverage, histograms, budget, worst ones; of "
      "--trial that run's own");
  app->add_option("--workers", options->workers, "machines at a time; default: cores")
      ->check(CLI::Range(1, kMostWorkers));
  app->add_flag("--resume", options->resume, "goes on with what the folder holds");
  app->add_flag("--progress",
                options->tells_progress,
                "for programs: a line of JSON on stdout now and then, how far it is");
  CLI::Option* const trial =
      app->add_option("--trial",
                      options->trial,
                      "runs this one alone and shows all of it; keeps nothing");
  CLI::Option* const shard =
      app->add_option("--shard", options->shard, "I/N: runs the I-th of N parts")
          ->excludes(trial);
  app->add_option("--merge",
                  options->merge,
                  "runs nothing: puts the parts in these folders together in --out")
      ->excludes(shard)
      ->excludes(trial)
      ->expected(1, kMostWorkers * kMostWorkers);
  app->footer(
      "Killed or interrupted, a study loses the trials on their way; `--resume` goes "
      "on. Results depend on the study and its seed, not on workers or order.");
  return [options] {
    return RunStudy(*options);
  };
}

}  // namespace caltwin

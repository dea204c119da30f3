#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "scenarios/interrupt.h"
#include "scenarios/result_text.h"
#include "scenarios/study/run.h"
#include "scenarios/study/summary.h"
#include "sim/base/text_file.h"
#include "tools/commands/command.h"
#include "tools/commands/progress.h"

namespace caltwin {

namespace fs = std::filesystem;

namespace {

constexpr int kJsonIndent = 2;
constexpr int kMostWorkers = 1024;

struct Options {
  std::string study{};
  std::string out{};
  int workers = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  bool resume = false;
  std::optional<std::int64_t> trial{};
};

// Of the whole study: "next_study" beside where one is.
fs::path FolderOf(const Options& options) {
  return options.out.empty() ? fs::path(options.study).stem() : fs::path(options.out);
}

int ReplayTrial(const Study& study, std::int64_t trial) {
  if (trial < 0 || trial >= study.trials) {
    throw InputError({.file = study.file.string()},
                     fmt::format("has no trial {}", trial),
                     fmt::format("there are 0 to {}", study.trials - 1));
  }
  bool lost = false;
  for (std::size_t i = 0; i < study.cases.size(); ++i) {
    const RunResult result = RunTrial(study, i, trial);
    std::cout << fmt::format("trial {} of {}\n", trial, study.cases[i].Name())
              << ResultText(result, MayPaint()) << "\n";
    lost = lost || result.lost;
  }
  return lost ? kLost : kPassed;
}

std::string ProgressText(const StudyProgress& progress) {
  constexpr int kWidth = 24;
  const double part = progress.all > 0 ? static_cast<double>(progress.done) /
                                             static_cast<double>(progress.all)
                                       : 1;
  const auto filled = static_cast<std::size_t>(kWidth * part);
  const double left_s =
      progress.per_s > 0
          ? static_cast<double>(progress.all - progress.done) / progress.per_s
          : 0;
  return fmt::format("[{}{}] {} of {}, {:.0f}/s, {:.0f} s left",
                     std::string(filled, '#'),
                     std::string(kWidth - filled, '.'),
                     progress.done,
                     progress.all,
                     progress.per_s,
                     left_s);
}

int Run(const Options& options) {
  const Study study = ReadStudy(options.study);
  if (options.trial) return ReplayTrial(study, *options.trial);
  const fs::path folder = FolderOf(options);
  StudyStore store(folder, study, options.resume);
  StudyProgress progress;
  {
    ProgressLine line;
    progress = RunStudy(study,
                        {.workers = options.workers,
                         .progress =
                             [&](const StudyProgress& now) {
                               line.Show(ProgressText(now));
                             }},
                        &store);
  }
  if (InterruptRequested()) {
    std::cerr << fmt::format(
        "{} of {} runs are kept in {}; --resume goes on with them\n",
        progress.done,
        progress.all,
        folder.string());
    return kInterrupted;
  }
  const StudySummary summary = SummaryOf(study, store);
  WriteTextFile(folder / "trials.csv", TrialsCsv(study, store));
  WriteTextFile(folder / "summary.json",
                SummaryJson(study, summary).dump(kJsonIndent) + "\n");
  std::cout << SummaryText(study, summary)
            << fmt::format("\n{}: trials.csv, summary.json, study.sqlite\n",
                           folder.string());
  return kPassed;
}

}  // namespace

Action DeclareStudy(CLI::App* app) {
  const auto options = std::make_shared<Options>();
  app->add_option("STUDY", options->study, "what to draw and compare (docs/studies.md)")
      ->required();
  app->add_option("--out", options->out, "folder; default: named after the study");
  app->add_option("--workers", options->workers, "machines at a time; default: cores")
      ->check(CLI::Range(1, kMostWorkers));
  app->add_flag("--resume", options->resume, "goes on with what the folder holds");
  app->add_option("--trial",
                  options->trial,
                  "runs this one alone and shows all of it; keeps nothing");
  app->footer(
      "Killed or interrupted, a study loses the trials on their way; `--resume` goes "
      "on. Results depend on the study and its seed, not on workers or order.");
  return [options] {
    return Run(*options);
  };
}

}  // namespace caltwin

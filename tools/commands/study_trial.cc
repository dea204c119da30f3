#include "tools/commands/study_trial.h"

#include <iostream>
#include <string>

#include <fmt/format.h>

#include "renders/report.h"
#include "renders/run_pictures.h"
#include "scenarios/result_text.h"
#include "sim/base/input_error.h"
#include "tools/commands/command.h"
#include "tools/commands/progress.h"

namespace caltwin {

namespace fs = std::filesystem;

namespace {

// Where the report of one contender goes: names may hold what paths cannot.
fs::path FolderOfStudyTrial(const Study& study,
                            std::size_t of_case,
                            const fs::path& report) {
  if (study.cases.size() == 1) return report;
  std::string name = study.cases[of_case].Name();
  for (char& c : name) {
    if (c == '/' || c == ':' || c == ' ') c = '_';
  }
  return report / name;
}

}  // namespace

int ReplayTrial(const Study& study, std::int64_t trial, const fs::path& report) {
  if (trial < 0 || trial >= study.most_trials) {
    throw InputError({.file = study.file.string()},
                     fmt::format("has no trial {}", trial),
                     fmt::format("there are 0 to {}", study.most_trials - 1));
  }
  bool lost = false;
  for (std::size_t i = 0; i < study.cases.size(); ++i) {
    const RunResult result = RunTrial(study, i, trial);
    std::cout << fmt::format("trial {} of {}\n", trial, study.cases[i].Name())
              << ResultText(result, MayPaint()) << "\n";
    lost = lost || result.lost;
    if (report.empty()) continue;
    const fs::path folder = FolderOfStudyTrial(study, i, report);
    WriteReport(result, PicturesOf(result), folder);
    std::cout << fmt::format("{}: index.html and its pictures\n", folder.string());
  }
  return lost ? kLost : kPassed;
}

}  // namespace caltwin

#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scenarios/runner.h"

namespace caltwin {

/// One contender of a study: a scenario, with its own `calibrate:` or with one of the
/// procedures compared in place of it.
struct StudyCase {
  Scenario scenario{};
  std::string procedure{};  ///< Compared; empty: as the scenario says.

  /// "first_light", or "first_light: next_all".
  std::string Name() const;
};

/// A Monte-Carlo study: so many machines, each calibrated by every contender. This
/// struct is the schema of study files (docs/studies.md).
struct Study {
  std::filesystem::path file{};
  std::string verbatim{};
  std::string about{};
  std::vector<StudyCase> cases{};
  Fidelity fidelity = Fidelity::kFast;
  std::int64_t trials = 0;
  std::uint64_t seed = 1;

  /// What must be the same for two runs to be parts of one study: the files' text and
  /// this program's version.
  std::string Fingerprint() const;
};

/// Reads `study: {about, scenarios, vary, compare, fidelity, trials, seed}`. Numbers of
/// `vary` replace those of every scenario: `backlash.x.gap_mm`,
/// `settings.backlash_mm.x`. Throws InputError with every fault of the study and of its
/// scenarios.
Study ReadStudy(const std::filesystem::path& file);

/// What one machine came out as, with one contender.
struct TrialResult {
  std::int64_t trial = 0;
  std::size_t of_case = 0;
  std::string status{};  ///< The run's outcome, as `caltwin run` judges it.
  double machine_time_s = 0;
  int touches = 0;
  double position_error_before_mm = 0, position_error_after_mm = 0;  ///< p95.
  std::vector<ParameterResult> parameters{};
  std::string message{};  ///< Of a trial that could not be run: why.
};

/// Runs it: trial K is machine K of the study's seed, whichever worker runs it and
/// whatever ran before.
RunResult RunTrial(const Study& study, std::size_t of_case, std::int64_t trial);

/// What is kept of a run.
TrialResult KeptOf(const RunResult& run, std::size_t of_case, std::int64_t trial);

}  // namespace caltwin

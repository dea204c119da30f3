#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scenarios/runner.h"
#include "scenarios/study/plan_study.h"

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
  /// Of a plan in place of scenarios; null: of scenarios. Then there is one case.
  std::shared_ptr<const PlanStudy> plan{};
  bool is_linear = false;    ///< Of a plan: rows drawn from its linear design.
  bool keeps_trials = true;  ///< Else aggregates alone, whatever the number of trials.
  std::int64_t trials = 0;
  /// Significant digits of u at which adaptive trials end; 0: `trials` of them. Then
  /// at most `most_trials`.
  int adaptive_digits = 0;
  std::int64_t most_trials = 0;
  std::uint64_t seed = 1;
  /// What of its distributions, and its scenarios', is not drawn as written: each once.
  std::vector<std::string> notes{};

  std::string FidelityWord() const;

  /// What must be the same for two runs to be parts of one study: the text of the
  /// study, its scenarios, their machines and models, and this program's version.
  std::string Fingerprint() const;
};

/// Reads `study: {about, scenarios | plan, vary, compare, fidelity, trials | adaptive,
/// keep, seed}`. Numbers of `vary` replace those of every scenario:
/// `backlash.x.gap_mm`, `settings.backlash_mm.x`. Throws InputError with every fault of
/// the study and of its scenarios.
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
  /// Why it ended as anything else than well: what could not be run, was missed, or the
  /// last message.
  std::string message{};

  bool HasFailed() const { return status == kFailed; }

  static constexpr const char* kFailed = "failed";  ///< Could not be run.
};

/// A part of a study that one machine of several runs: every `count`-th trial, from
/// `index` (counted from 0) on. Whole by default.
struct Shard {
  std::int64_t index = 0, count = 1;

  bool Has(std::int64_t trial) const { return trial % count == index; }
  /// How many of so many it has: trials index, index + count, index + 2 count ...
  std::int64_t NumOf(std::int64_t trials) const {
    return (trials - index + count - 1) / count;
  }
  /// As written: "2/5", counted from 1.
  std::string Text() const;
};

/// Reads "I/N"; throws InputError where I is not 1 to N.
Shard ReadShard(const std::string& text);

/// Runs it: trial K is machine K of the study's seed, whichever worker runs it and
/// whatever ran before.
RunResult RunTrial(const Study& study, std::size_t of_case, std::int64_t trial);

/// Why a run did not recover or fit: what it missed, or its last message; else empty.
std::string CauseOf(const RunResult& run);

/// What is kept of a run.
TrialResult KeptOf(const RunResult& run, std::size_t of_case, std::int64_t trial);

}  // namespace caltwin

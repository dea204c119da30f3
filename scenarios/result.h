#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "calibration/estimate/expanded.h"
#include "calibration/loop/message.h"
#include "calibration/loop/outcome.h"
#include "sim/machine/machine.h"
#include "sim/measure/data_header.h"
#include "sim/measure/row.h"

namespace caltwin {

/// One row of a run's table: what was injected, what came out.
struct ParameterResult {
  std::string name{};
  std::string unit{};
  double injected = 0;                ///< The built, absolute value.
  std::optional<double> recovered{};  ///< None where not identifiable.
  std::optional<double> sd{};
  std::vector<Contribution> budget{};  ///< What sd is made of; empty: not taken apart.
  std::optional<double> error{};       ///< recovered - injected.
  std::optional<double> tolerance{};   ///< What was expected; none: nothing.
  std::optional<bool> passed{};
  /// What the firmware believes at the end; none: no setting. Not written.
  std::optional<double> believed{};
  bool identifiable = false;
  bool is_setting = false;
};

/// sd and budget of an estimate; none where it was told without error (a sd of 0).
void SetUncertainty(const Estimate& estimate, ParameterResult* row);

/// The whole of a row's budget as one line, of its sd as normal where it has none:
/// combined u and effective degrees of freedom. nullopt where it states none.
std::optional<Contribution> CombinedOf(const ParameterResult& row);

/// u, k, U and effective degrees of freedom of what a run states: of its budget, else
/// of its sd as normal. nullopt where it states none.
std::optional<Expanded> ExpandedOf(const ParameterResult& row);

/// A check that is no parameter's: "outcome", "position_error_mm.p95".
struct CheckResult {
  std::string name{};
  std::string expected{};
  std::string found{};
  bool passed = false;
};

/// What `caltwin run` prints, draws and writes of one run of one scenario.
struct RunResult {
  std::string scenario{};  ///< The file, as given.
  std::string about{};
  std::string verbatim{};  ///< The scenario's text, kept with its result.
  std::string machine{};
  bool passed = false;
  std::string outcome{};   ///< recovers | diverges | ... as in CONTRACT.
  std::string fidelity{};  ///< physics | fast
  std::uint64_t seed = 1;
  std::vector<ParameterResult> parameters{};
  std::vector<CheckResult> checks{};
  std::vector<Step> steps{};
  std::vector<Correlations> correlations{};  ///< A procedure's fit each.
  std::vector<Observability> observability{};
  std::vector<Message> messages{};
  /// What went wrong and why, of `messages`, each once; where nothing names it, what
  /// the machine said when it stopped.
  std::vector<std::string> Causes() const;
  double position_error_before_p95_mm = 0;  ///< At 1000 seeded poses, both senses.
  double position_error_after_p95_mm = 0;
  /// Both are instead how far the clean nozzle, commanded to 0 over the middle of the
  /// bed, is from its surface.
  bool is_error_of_nozzle = false;
  /// The figure that its kind is calibrated for (TrueFigure), in the kind's own unit;
  /// none where it has none. Not written.
  std::optional<double> figure_before{}, figure_after{};
  double machine_time_s = 0;
  double cpu_s = 0;
  int touches = 0;
  DataHeader header{};       ///< What explains the rows.
  RowTable rows{};           ///< Every reading taken.
  std::string transcript{};  ///< Where it was asked for. Not written as JSON.
  Settings
      settings_before{};  ///< What the firmware believed at power-up, and at the end.
  Settings settings_after{};
  bool lost = false;         ///< A process or link was lost on the way.
  bool interrupted = false;  ///< By Ctrl-C; what was done until then is here.
};

/// The tree of `caltwin run --json`.
nlohmann::ordered_json ToJson(const RunResult& result);

/// What a procedure did, and what it knows of its estimates, behind what others did
/// before it; what it cannot tell is said once.
void AddDone(const ProcedureResult& part, RunResult* result);

/// Of its fits, and what its results have in common that were told one by one
/// (SharedCorrelations).
std::vector<Correlations> AllCorrelations(const RunResult& result);

/// Names, matrix, and the ten largest pairs.
nlohmann::ordered_json ToJson(const Correlations& of);

/// How often an interval of 95 % (value +- 1.96 sd) held the truth, over all
/// identifiable parameters of all runs that stated an uncertainty; nullopt where there
/// is none.
std::optional<double> Coverage95(std::span<const RunResult> results);

}  // namespace caltwin

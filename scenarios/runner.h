#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "scenarios/result.h"
#include "scenarios/scenario.h"
#include "sim/twin/twin.h"

namespace caltwin {

/// What a run may be told beside its scenario.
struct RunOptions {
  std::optional<Fidelity> fidelity{};
  std::optional<std::uint64_t> seed{};
  std::uint64_t sample = 0;
  std::filesystem::path transcript{};  ///< Every line and answer; empty: not kept.
  bool holds_transcript = false;       ///< In RunResult::transcript, for a report.
  /// What is being done now, for a progress line.
  std::function<void(const std::string&)> progress = [](const std::string&) {
  };
};

/// What the options leave of a scenario's own seed and fidelity.
Chance ChanceOf(const Scenario& scenario, const RunOptions& options);

/// Runs a scenario closed-loop and judges it, whatever kind of machine it has: the
/// steps speak G-code to the machine and read its instruments, nothing else. A fault of
/// the machine ends it early and is an outcome; throws InputError for what only drawing
/// the numbers can show.
RunResult RunScenario(const Scenario& scenario, const RunOptions& options = {});

}  // namespace caltwin

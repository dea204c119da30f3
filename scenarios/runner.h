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
  /// What is being done now, for a progress line.
  std::function<void(const std::string&)> progress = [](const std::string&) {
  };
};

/// The twin of a scenario before anything is calibrated: its numbers drawn, the
/// machine file's effects included. The same for the same seed and sample.
TwinConfig MakeTwinConfig(const Scenario& scenario, const RunOptions& options = {});

/// 95 % quantile of the tip's position error [mm] at 1000 seeded poses within the
/// travel, each reached in the sense + + + and in - - -, the mean offset over all of
/// them removed. That offset is where the part's zero goes, so nobody cuts it.
double PositionErrorP95_mm(const Twin& twin);

/// Runs a scenario closed-loop and judges it. A fault of the machine ends it early and
/// is an outcome; throws InputError for what only drawing the numbers can show.
RunResult RunScenario(const Scenario& scenario, const RunOptions& options = {});

}  // namespace caltwin

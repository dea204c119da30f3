#pragma once

#include <cstdint>
#include <filesystem>

#include "scenarios/study/study.h"

namespace caltwin {

/// Runs one trial of every contender alone and prints all of each; with `report`
/// (empty: none) a report of each in a folder of its own there where there are several.
/// Returns the exit code; throws InputError where the study has no such trial.
int ReplayTrial(const Study& study,
                std::int64_t trial,
                const std::filesystem::path& report);

}  // namespace caltwin

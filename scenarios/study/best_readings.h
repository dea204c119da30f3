#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "scenarios/study/plan_study.h"

namespace caltwin {

/// What a plan's readings are worth, one by one.
struct ReadingsWorth {
  double all = 1;                  ///< Relative sd (NextReading) after the whole plan.
  EnoughReadings enough{};         ///< Those that tell each quantity within 5 % of it.
  NextReading next_d{}, next_a{};  ///< To take after all of them.
  ObservabilityReport observed{};  ///< What is told, what is blind.
};

ReadingsWorth WorthOf(const PlanStudy& plan);

/// For `summary.json`: rank, blind directions, the readings that are enough, and the
/// next, each with its place in the plan (rows counted from 1).
nlohmann::ordered_json ToJson(const PlanStudy& plan, const ReadingsWorth& worth);

/// What the terminal shows.
std::string WorthText(const PlanStudy& plan, const ReadingsWorth& worth);

}  // namespace caltwin

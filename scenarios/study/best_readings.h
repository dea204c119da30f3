#pragma once

#include <string>
#include <vector>

#include "scenarios/study/plan_study.h"

namespace caltwin {

/// What a plan's readings are worth, one by one.
struct ReadingsWorth {
  double all = 1;                  ///< Relative sd (NextReading) after the whole plan.
  EnoughReadings enough{};         ///< Those that tell each quantity within 5 % of it.
  NextReading next_d{}, next_a{};  ///< To take after all of them.
  std::string told{};              ///< In words: what is told, what is blind.
};

ReadingsWorth WorthOf(const PlanStudy& plan);

/// What the terminal shows.
std::string WorthText(const PlanStudy& plan, const ReadingsWorth& worth);

}  // namespace caltwin

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scenarios/study/store.h"

namespace caltwin {

/// One input of a budget.
struct BudgetLine {
  std::string input{};      ///< A varied parameter; empty: the readings and all else.
  double u = 0;             ///< Standard deviation of the input over the machines.
  double c = 0;             ///< Sensitivity: how much the error grows with it.
  double contribution = 0;  ///< |c| u, in the estimate's unit.
  double share = 0;         ///< Of the error's variance.
};

/// Where the error of one estimate comes from: regression of it on what was varied.
///
///   error = c0 + sum c_i (x_i - mean) + rest
///
/// `rest` is what the readings' noise, steps and whatever is not straight leave. Lines
/// smaller than chance makes them (three standard deviations of c) are counted to the
/// rest. Correlated inputs share as the regression divides them; one that those before
/// it (by name) determine is the same input and left out.
struct Budget {
  std::string name{}, unit{};
  double u = 0;                     ///< Standard deviation of the error.
  std::vector<BudgetLine> lines{};  ///< The largest share first.
};

/// One for each parameter told, by contender.
std::vector<std::vector<Budget>> BudgetsOf(const Study& study, const StudyStore& store);

/// What the terminal shows.
std::string BudgetText(const std::string& of, const std::vector<Budget>& budgets);

}  // namespace caltwin

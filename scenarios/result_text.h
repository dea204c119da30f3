#pragma once

#include <optional>
#include <span>
#include <string>

#include "scenarios/result.h"

namespace caltwin {

/// What `caltwin run` prints of one run: the table, what was done in order, what the
/// measurements cannot tell, messages, checks, and the verdict. `colour` paints the
/// verdicts for a terminal.
std::string ResultText(const RunResult& result, bool colour = false);

/// What it prints on a terminal: the verdict in a sentence, the table, what failed, and
/// how much more there is to read.
std::string ResultBrief(const RunResult& result, bool colour = false);

/// One line of it: verdict, file, seed, outcome, rows passed.
std::string ResultLine(const RunResult& result, bool colour = false);

/// The last line of many: count, pass rate, how often stated intervals held the truth.
std::string SummaryText(std::span<const RunResult> results);

/// "backlash.x: 0.0213 +- 0.0014 mm, k = 1.96: hysteresis 58 %, readings 42 %": value
/// +- U, and the share of each input. Empty where the row states no uncertainty.
std::string UncertaintyText(const ParameterResult& row);

/// "joint_estimate, most correlated: backlash.x with probe_pretravel.x -0.93"; empty
/// where no pair reaches 0.1.
std::string CorrelationText(const Correlations& of);

/// "hysteresis 58 %, readings 42 %": shares of the variance, the largest first, those
/// of half a percent and more; empty where the row has no budget.
std::string SharesText(const ParameterResult& row);

/// Effective degrees of freedom as they are looked up, whole: "16"; "inf" where they
/// are a thousand and more, whose k is the normal distribution's.
std::string DofText(double dof);

/// `value` with as many decimals as its `resolution` (an uncertainty or a tolerance)
/// makes sensible: two significant digits of it, at most 6 decimals; without one, six
/// significant digits.
std::string Sensible(double value, std::optional<double> resolution);

}  // namespace caltwin

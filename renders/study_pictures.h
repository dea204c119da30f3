#pragma once

#include <string>
#include <vector>

#include "scenarios/study/summary.h"

namespace caltwin {

/// @name Pictures of a study's report: SVG that carries its own colours
/// Errors of one parameter, and the curve that its stated uncertainty promises.
std::string HistogramSvg(const ParameterSummary& parameter);
/// How often intervals of 95 % held, each with its own 95 % interval, against 93 to
/// 97 %.
std::string CoverageSvg(const std::vector<ParameterSummary>& parameters);

}  // namespace caltwin

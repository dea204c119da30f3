#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "renders/chart.h"
#include "renders/display_unit.h"
#include "renders/parts.h"
#include "renders/sections/sections.h"

namespace caltwin {
namespace {

const ParameterResult* FindResult(const RunResult& result, const std::string& name) {
  const auto found = std::ranges::find(result.parameters, name, &ParameterResult::name);
  return found == result.parameters.end() ? nullptr : &*found;
}

/// "steps_per_mm" of "steps_per_mm.x": what shares a plot.
std::string CauseOf(const std::string& name) {
  return name.substr(0, name.find('.'));
}

/// The error of one quantity over the whole run: level between the steps that had to
/// do with it, a slope across each of them. Empty where none had.
ChartSeries ErrorsOf(const RunResult& result,
                     const ParameterResult& truth,
                     double per_unit) {
  ChartSeries series{.label = truth.name, .is_line = true};
  const auto add = [&](std::size_t step, double value) {
    const auto x = static_cast<double>(step);
    if (!series.x.empty() && series.x.back() == x) return;
    series.x.push_back(x);
    series.y.push_back((value - truth.injected) * per_unit);
  };
  double last = 0;
  for (std::size_t i = 0; i < result.steps.size(); ++i) {
    const Step& step = result.steps[i];
    if (step.name != truth.name) continue;
    if (series.x.empty()) add(0, step.before);
    add(i, step.before);
    add(i + 1, step.after);
    last = step.after;
  }
  if (!series.x.empty()) add(result.steps.size(), last);
  return series;
}

std::vector<std::string> CausesInOrder(const RunResult& result) {
  std::vector<std::string> causes;
  for (const Step& step : result.steps) {
    const ParameterResult* truth = FindResult(result, step.name);
    if (truth == nullptr || !truth->is_setting) continue;
    const std::string cause = CauseOf(step.name);
    if (std::ranges::find(causes, cause) == causes.end()) causes.push_back(cause);
  }
  return causes;
}

std::string FigureOf(const RunResult& result, const std::string& cause) {
  std::string label;
  std::vector<ChartSeries> all;
  for (const ParameterResult& truth : result.parameters) {
    if (CauseOf(truth.name) != cause || !truth.is_setting) continue;
    const std::string unit = truth.unit.empty() ? UnitOfName(truth.name) : truth.unit;
    const ErrorUnit shown = ErrorUnitOf(unit);
    ChartSeries series = ErrorsOf(result, truth, shown.per_unit);
    if (series.x.empty()) continue;
    label = fmt::format("error [{}]", shown.name);
    all.push_back(std::move(series));
  }
  return FigureHtml(cause,
                    "setting minus truth; it should end on zero.",
                    ChartSvg("step", label, all));
}

}  // namespace

std::string ConvergenceSection(const RunResult& result,
                               const ReportPictures& /*pictures*/) {
  std::string plots;
  for (const std::string& cause : CausesInOrder(result)) {
    plots += FigureOf(result, cause);
  }
  if (plots.empty()) return "";
  return "<p>Error of each setting after every step that touched it. The steps are "
         "numbered as in the table above.</p>\n<div class=\"drawings\">\n" +
         plots + "</div>\n";
}

}  // namespace caltwin

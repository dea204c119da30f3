#include "scenarios/kind_scenario.h"

#include <algorithm>

#include "scenarios/gcode_step.h"
#include "scenarios/named_step.h"

namespace caltwin {
namespace {

// What every machine on a wire can be asked for.
CalibrationStep ReadAnyStep(const NamedStep& step,
                            const KindScenario& kind,
                            const std::vector<std::string>& names,
                            const std::string& usual_axis) {
  if (step.name == "external") {
    return {.name = step.name, .external = ReadExternal(step.options.Map())};
  }
  if (step.name == "gcode") {
    return {.name = step.name, .procedure = ReadGcodeStep(step.options.Map())};
  }
  if (std::ranges::find(names, step.name) == names.end()) {
    kind.RefuseStep(step.name, step.options);
    return {.name = step.name};
  }
  return kind.ReadStep(step.name, step.options, usual_axis);
}

}  // namespace

std::vector<CalibrationStep> ReadCalibrationSteps(const YamlValue& list,
                                                  const KindScenario& kind,
                                                  const std::string& usual_axis) {
  const std::vector<std::string> names = kind.StepNames();
  std::vector<CalibrationStep> steps;
  for (const NamedStep& step : ReadNamedSteps(list)) {
    steps.push_back(ReadAnyStep(step, kind, names, usual_axis));
  }
  return steps;
}

}  // namespace caltwin

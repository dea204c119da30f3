#include "scenarios/kind_scenario.h"

#include <algorithm>
#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scenarios/gcode_step.h"
#include "scenarios/kinds/kinds.h"
#include "scenarios/named_step.h"

namespace caltwin {
namespace {

// The kinds that have such a procedure, in words; empty: none.
std::string OwnersOf(const std::string& name) {
  std::vector<std::string_view> owners;
  for (const auto& kind : AllKindScenarios()) {
    if (FindProcedure(name, kind->KnownProcedures()) != nullptr) {
      owners.push_back(kind->Owner());
    }
  }
  return fmt::format("{}", fmt::join(owners, " and "));
}

// What the file leaves out, as if `text` stood at that place.
YamlMap Unwritten(const std::string& text, const YamlValue& at, Faults* faults) {
  const Place place = at.place();
  const auto lines = static_cast<std::size_t>(std::max(1, place.line) - 1);
  const auto columns = static_cast<std::size_t>(std::max(1, place.column) - 1);
  const YAML::Node node =
      YAML::Load(std::string(lines, '\n') + std::string(columns, ' ') + text);
  return {node, at.file(), at.path(), faults};
}

// The options of a procedure by its name alone: an axis where it needs one.
YamlMap UsualOptions(const Procedure& procedure,
                     const Machine& machine,
                     const YamlValue& at,
                     const std::string& usual_axis) {
  Faults lacking;
  if (!usual_axis.empty()) procedure.prepare(Unwritten("{}", at, &lacking), machine);
  if (lacking.empty()) return Unwritten("{}", at, at.faults());
  return Unwritten(procedure.takes_axes ? fmt::format("{{axes: [{}]}}", usual_axis)
                                        : fmt::format("{{axis: {}}}", usual_axis),
                   at,
                   at.faults());
}

// What every machine on a wire can be asked for.
CalibrationStep ReadAnyStep(const NamedStep& step,
                            const KindScenario& kind,
                            const Machine& machine,
                            const std::string& usual_axis) {
  if (step.name == "external") {
    return {.name = step.name, .external = ReadExternal(step.options.Map())};
  }
  if (step.name == "gcode") {
    return {.name = step.name, .procedure = ReadGcodeStep(step.options.Map())};
  }
  const std::vector<std::string> names = kind.StepNames();
  if (std::ranges::find(names, step.name) == names.end()) {
    kind.RefuseStep(step.name, step.options);
    return {.name = step.name};
  }
  return kind.ReadStep(step.name, step.options, machine, usual_axis);
}

}  // namespace

CalibrationStep KindScenario::ReadScenarioStep(const std::string& name,
                                               YamlMap options) const {
  options.NoMoreKeys();
  throw std::logic_error(name + " is no step of this kind's scenarios");
}

std::unique_ptr<KindTrial> KindScenario::BeginUnderKlipper(
    const Scenario& /*scenario*/, const Chance& /*chance*/) const {
  throw std::logic_error("no such machine is driven by Klipper's host");
}

std::unique_ptr<KindTrial> KindScenario::BeginUnderLinuxCnc(
    const Scenario& /*scenario*/, const Chance& /*chance*/) const {
  throw std::logic_error("no such machine is driven by LinuxCNC");
}

void KindScenario::RefuseStep(const std::string& name, const YamlValue& options) const {
  std::vector<std::string> names = StepNames();
  names.insert(names.end(), {"gcode", "external"});
  const std::string nearest = NearestWord(name, names);
  const std::string all = fmt::format("{}", fmt::join(names, ", "));
  const std::string others = OwnersOf(name);
  if (!others.empty()) {
    options.Fail(fmt::format("is a procedure of {}, not of {}", others, Owner()),
                 fmt::format("there are {}", all));
    return;
  }
  options.Fail(fmt::format("is no procedure of {}", Owner()),
               nearest.empty()
                   ? fmt::format("there are {}", all)
                   : fmt::format("did you mean '{}'? There are {}", nearest, all));
}

std::vector<std::string> KindScenario::StepNames() const {
  std::vector<std::string> names;
  for (const Procedure* one : KnownProcedures()) names.emplace_back(one->name);
  for (const Word& step : ScenarioSteps()) names.emplace_back(step.name);
  return names;
}

CalibrationStep KindScenario::ReadStep(const std::string& name,
                                       const YamlValue& options,
                                       const Machine& machine,
                                       const std::string& usual_axis) const {
  const Procedure* const procedure = FindProcedure(name, KnownProcedures());
  // An empty value means that all options are left out.
  if (procedure == nullptr) {
    return ReadScenarioStep(
        name,
        options.is_null() ? Unwritten("{}", options, options.faults()) : options.Map());
  }
  CalibrationStep step{.name = name};
  if (options.is_map()) step.variant = options.Map().TextOr("variant", "");
  step.procedure = procedure->prepare(
      options.is_null() ? UsualOptions(*procedure, machine, options, usual_axis)
                        : options.Map(),
      machine);
  return step;
}

std::vector<CalibrationStep> ReadCalibrationSteps(const YamlValue& list,
                                                  const KindScenario& kind,
                                                  const Machine& machine,
                                                  const std::string& usual_axis) {
  std::vector<CalibrationStep> steps;
  for (const NamedStep& step : ReadNamedSteps(list)) {
    steps.push_back(ReadAnyStep(step, kind, machine, usual_axis));
  }
  return steps;
}

}  // namespace caltwin

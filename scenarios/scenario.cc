#include "scenarios/scenario.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scenarios/gcode_step.h"
#include "scenarios/named_step.h"
#include "sim/base/text_file.h"

namespace caltwin {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kLargestFile_bytes = 1'000'000;
constexpr std::int64_t kLargestSeed = std::int64_t{1} << 53;  // JSON keeps it exactly.

void ReadMachineKey(YamlMap* map, const fs::path& folder, Scenario* scenario) {
  const auto machine = map->Required("machine");
  if (!machine) return;
  const std::string name = machine->Text();
  if (name.empty()) return;
  const fs::path file = FindMachine(name, folder, machine->place());
  if (IsMotorStage(file)) {
    scenario->motor = MotorScenario{.drawing = ReadMotorStage(file)};
    return;
  }
  scenario->machine = ReadAnyMachineFile(file);
  scenario->effects = scenario->machine.effects;
}

void RefuseTwice(const std::vector<InjectedSpec>& specs, Faults* faults) {
  for (std::size_t i = 0; i < specs.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (specs[i].effect != specs[j].effect || specs[i].axis != specs[j].axis)
        continue;
      faults->Add(specs[i].place,
                  "this effect is already in the machine file",
                  "an effect is given once: leave it out here or there");
    }
  }
}

FirmwareOptions ReadFirmware(YamlMap map) {
  FirmwareOptions options;
  options.m400_ignores_backlash = map.FlagOr("m400_ignores_backlash", false);
  if (const auto files = map.Optional("files")) {
    for (const auto& [path, text] : files->Map().Entries()) {
      options.files[path] = text.Text();
    }
  }
  map.NoMoreKeys();
  return options;
}

std::vector<std::string> StepNames() {
  std::vector<std::string> names = {"external", "gcode"};
  for (const Procedure& procedure : AllProcedures()) names.emplace_back(procedure.name);
  return names;
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
                     const YamlValue& at,
                     const std::string& usual_axis) {
  Faults lacking;
  if (!usual_axis.empty()) procedure.prepare(Unwritten("{}", at, &lacking));
  return Unwritten(lacking.empty() ? "{}" : fmt::format("{{axis: {}}}", usual_axis),
                   at,
                   at.faults());
}

CalibrationStep ReadStep(const std::string& name,
                         const YamlValue& options,
                         const std::string& usual_axis) {
  CalibrationStep step{.name = name};
  if (name == "external") {
    step.external = ReadExternal(options.Map());
    return step;
  }
  if (name == "gcode") {
    step.procedure = ReadGcodeStep(options.Map());
    return step;
  }
  const Procedure* procedure = FindProcedure(name);
  if (procedure == nullptr) {
    const std::string nearest = NearestWord(name, StepNames());
    options.Fail("is no procedure that this version knows",
                 (nearest.empty() ? "" : fmt::format("did you mean '{}'? ", nearest)) +
                     "`caltwin explain` lists them all");
    return step;
  }
  if (options.is_map()) step.variant = options.Map().TextOr("variant", "");
  // An empty value means a procedure with all its options left out.
  step.procedure = procedure->prepare(
      options.is_null() ? UsualOptions(*procedure, options, usual_axis)
                        : options.Map());
  return step;
}

void ReadTwinKeys(YamlMap* map, Scenario* scenario) {
  if (const auto effects = map->Optional("effects")) {
    const auto more = ReadEffects(effects->Map(), scenario->machine.machine);
    scenario->effects.insert(scenario->effects.end(), more.begin(), more.end());
    RefuseTwice(scenario->effects, map->faults());
  }
  if (const auto settings = map->Optional("settings")) {
    scenario->settings = ReadSettingSpecs(settings->Map());
  }
  if (const auto instruments = map->Optional("instruments")) {
    scenario->instruments = ReadInstruments(instruments->Map());
  }
  if (const auto artefacts = map->Optional("artefacts")) {
    scenario->artefacts = ReadArtefacts(artefacts->Map());
  }
  RefuseUnknownArtefacts(scenario->effects, IdsOf(scenario->artefacts), map->faults());
  if (const auto firmware = map->Optional("firmware")) {
    scenario->firmware = ReadFirmware(firmware->Map());
  }
}

}  // namespace

std::vector<CalibrationStep> ReadCalibrationSteps(const YamlValue& list,
                                                  const std::string& usual_axis) {
  std::vector<CalibrationStep> steps;
  for (const NamedStep& step : ReadNamedSteps(list)) {
    steps.push_back(ReadStep(step.name, step.options, usual_axis));
  }
  return steps;
}

namespace {

// All but what every scenario has, by the kind of its machine.
void ReadBody(YamlMap* map, Scenario* scenario) {
  const Machine& machine = scenario->machine.machine;
  const auto& effects = scenario->machine.effects;
  if (scenario->motor) {
    scenario->motor = ReadMotorScenario(map, scenario->motor->drawing);
  } else if (machine.delta) {
    scenario->delta = ReadDeltaScenario(map, machine, effects);
  } else if (map->Has("station") || machine.z_station) {
    scenario->z_offset = ReadZOffsetScenario(map, machine);
  } else if (machine.triple_z) {
    scenario->triple_z = ReadTripleZScenario(map, machine, effects);
  } else {
    ReadTwinKeys(map, scenario);
    if (const auto calibrate = map->Required("calibrate")) {
      scenario->calibrate = ReadCalibrationSteps(*calibrate);
    }
    if (const auto expect = map->Optional("expect")) {
      scenario->expect = ReadExpectation(expect->Map());
    }
  }
}

}  // namespace

Scenario ReadScenarioText(const std::string& text, const fs::path& name) {
  Faults faults;
  YamlMap map = ReadYamlText(text, name.string(), &faults);
  Scenario scenario{.file = name, .verbatim = text};
  scenario.about = map.TextOr("about", "");
  ReadMachineKey(&map, name.parent_path(), &scenario);
  scenario.seed = static_cast<std::uint64_t>(map.IntegerOr("seed", 1, 0, kLargestSeed));
  scenario.fidelity = map.WordOr("fidelity", "physics", {"physics", "fast"}) == "fast"
                          ? Fidelity::kFast
                          : Fidelity::kPhysics;
  ReadBody(&map, &scenario);
  map.NoMoreKeys();
  faults.ThrowIfAny();
  scenario.notes = scenario.machine.draws;
  scenario.notes.insert(
      scenario.notes.end(), faults.notes().begin(), faults.notes().end());
  return scenario;
}

Scenario ReadScenario(const fs::path& file) {
  return ReadScenarioText(ReadTextFile(file, kLargestFile_bytes), file);
}

}  // namespace caltwin

#include "scenarios/scenario.h"

#include "scenarios/gcode_step.h"
#include "scenarios/kinds/kinds.h"
#include "sim/base/text_file.h"

namespace caltwin {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kLargestSeed = std::int64_t{1} << 53;  // JSON keeps it exactly.

// The machine, and what its kind has of its own.
void ReadMachineKey(YamlMap* map, const fs::path& folder, Scenario* scenario) {
  const auto machine = map->Required("machine");
  const std::string name = machine ? machine->Text() : "";
  const fs::path file =
      name.empty() ? fs::path{} : FindMachine(name, folder, machine->place());
  scenario->kind = AnyKindScenario(ReadKind(file, map, &scenario->machine));
  scenario->effects = scenario->machine.effects;
}

// Lines for Klipper's own host, in place of `calibrate`.
void ReadUnderKlipper(YamlMap keys, const fs::path& folder, Scenario* scenario) {
  scenario->klipper.emplace();
  if (const auto config = keys.Optional("config")) {
    const fs::path file = folder / config->Text();
    std::error_code error;
    if (fs::is_regular_file(file, error) && fs::is_empty(file, error)) {
      config->Fail("is an empty file", "leave it away, and one is made of the machine");
    } else if (fs::is_regular_file(file, error)) {
      scenario->klipper->config = ReadTextFile(file, kLargestFile_bytes);
      scenario->klipper->beside = fs::absolute(file).parent_path();
    } else {
      config->Fail(
          "there is no file " + file.string(),
          "a printer.cfg, relative to this file; without it one is made of the "
          "machine");
    }
  }
  scenario->klipper->add = keys.TextOr("add", "");
  std::vector<std::string> lines;
  if (const auto gcode = keys.Required("gcode")) {
    for (const YamlValue& line : gcode->List()) lines.push_back(line.Text());
    if (gcode->is_list() && lines.empty()) {
      gcode->Fail("says nothing", "as in `gcode: [G28, DELTA_CALIBRATE, SAVE_CONFIG]`");
    }
  }
  keys.NoMoreKeys();
  scenario->calibrate = {{.name = "klipper", .procedure = GcodeStep(lines)}};
}

void ReadController(const YamlValue& value,
                    const fs::path& folder,
                    Scenario* scenario) {
  YamlMap keys = value.Map();
  if (const auto klipper = keys.Required("klipper")) {
    ReadUnderKlipper(klipper->Map(), folder, scenario);
    if (!scenario->kind->CanBeUnderKlipper()) {
      klipper->Fail(
          "such a machine cannot yet be driven by Klipper's host in a scenario",
          "single motors speak another language");
    }
  }
  keys.NoMoreKeys();
}

// What is done: by the engine, step by step, or by a real controller.
void ReadWhatIsDone(YamlMap* map, const fs::path& folder, Scenario* scenario) {
  const auto controller = map->Optional("controller");
  if (!controller) {
    if (const auto calibrate = map->Required("calibrate")) {
      scenario->calibrate =
          ReadCalibrationSteps(*calibrate, *scenario->kind, scenario->machine.machine);
    }
    return;
  }
  ReadController(*controller, folder, scenario);
  if (const auto calibrate = map->Optional("calibrate")) {
    calibrate->Fail("stands beside `controller`, which calibrates in its place",
                    "leave one of them away");
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
  scenario.kind->ReadKeys(&map, &scenario);
  ReadWhatIsDone(&map, name.parent_path(), &scenario);
  if (const auto expect = map.Optional("expect")) {
    scenario.expect = ReadExpectation(expect->Map(), scenario.kind->CanExpect());
  }
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

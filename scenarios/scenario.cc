#include "scenarios/scenario.h"

#include "scenarios/controller.h"
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

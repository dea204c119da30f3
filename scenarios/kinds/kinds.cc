#include "scenarios/kinds/kinds.h"

#include <utility>

#include "scenarios/kinds/delta_scenario.h"
#include "scenarios/kinds/gantry_scenario.h"
#include "scenarios/kinds/motor_stage_scenario.h"
#include "scenarios/kinds/triple_z_scenario.h"
#include "scenarios/kinds/z_station_scenario.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/motor_stage/drawing.h"
#include "sim/machine/kinds/triple_z/drawing.h"
#include "sim/machine/kinds/z_station/drawing.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {

std::unique_ptr<KindScenario> UsualKind(const MachineKind* kind) {
  return std::make_unique<GantryScenario>(kind);
}

std::vector<std::unique_ptr<KindScenario>> AllKindScenarios() {
  std::vector<std::unique_ptr<KindScenario>> all;
  all.push_back(UsualKind());
  all.push_back(std::make_unique<DeltaScenario>());
  all.push_back(std::make_unique<TripleZScenario>());
  all.push_back(std::make_unique<ZStationScenario>());
  all.push_back(std::make_unique<MotorStageScenario>());
  return all;
}

std::unique_ptr<KindScenario> ScenarioOf(const MachineKind& kind) {
  for (auto& one : AllKindScenarios()) {
    const Procedures procedures = one->KnownProcedures();
    const bool is_of_it =
        !procedures.empty() && procedures.front()->kind == kind.name();
    if (is_of_it) return std::move(one);
  }
  return UsualKind(&kind);
}

std::unique_ptr<KindScenario> KindFor(const Machine& machine, bool has_station) {
  if (const auto* const motors = machine.Own<MotorStageDrawing>()) {
    auto stage = std::make_unique<MotorStageScenario>();
    stage->drawing = *motors;
    return stage;
  }
  if (machine.Own<DeltaDrawing>() != nullptr) return std::make_unique<DeltaScenario>();
  // A station may stand at any printer.
  if (has_station || machine.Own<ZStationDrawing>() != nullptr) {
    return std::make_unique<ZStationScenario>();
  }
  if (machine.Own<TripleZDrawing>() != nullptr)
    return std::make_unique<TripleZScenario>();
  return UsualKind(machine.kind);
}

std::unique_ptr<KindScenario> ReadKind(const std::filesystem::path& file,
                                       YamlMap* map,
                                       MachineFile* machine) {
  if (file.empty()) {  // A fault already: `station` is no unknown key beside it.
    map->Has("station");
    return UsualKind();
  }
  *machine = ReadAnyMachineFile(file);
  const bool may_have_station = machine->machine.kind->moves_along_axes();
  return KindFor(machine->machine, may_have_station && map->Has("station"));
}

}  // namespace caltwin

#include "scenarios/kinds/kinds.h"

#include "scenarios/kinds/delta_scenario.h"
#include "scenarios/kinds/gantry_scenario.h"
#include "scenarios/kinds/motor_stage_scenario.h"
#include "scenarios/kinds/triple_z_scenario.h"
#include "scenarios/kinds/z_station_scenario.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/triple_z/drawing.h"
#include "sim/machine/kinds/z_station/drawing.h"

namespace caltwin {

std::unique_ptr<KindScenario> UsualKind(const MachineKind* kind) {
  return std::make_unique<GantryScenario>(kind);
}

std::unique_ptr<KindScenario> ReadKind(const std::filesystem::path& file,
                                       YamlMap* map,
                                       MachineFile* machine) {
  if (file.empty()) {  // A fault already; the keys that there are are told.
    map->Has("station");
    return UsualKind();
  }
  if (IsMotorStage(file)) {
    auto stage = std::make_unique<MotorStageScenario>();
    stage->drawing = ReadMotorStage(file);
    machine->machine.name = stage->drawing.name;
    return stage;
  }
  *machine = ReadAnyMachineFile(file);
  if (machine->machine.Own<DeltaDrawing>() != nullptr)
    return std::make_unique<DeltaScenario>();
  // A station may stand at any printer.
  if (map->Has("station") || machine->machine.Own<ZStationDrawing>() != nullptr) {
    return std::make_unique<ZStationScenario>();
  }
  if (machine->machine.Own<TripleZDrawing>() != nullptr)
    return std::make_unique<TripleZScenario>();
  return UsualKind();
}

}  // namespace caltwin

#include "tools/commands/kinds/still.h"

#include <optional>
#include <type_traits>
#include <utility>

#include <fmt/format.h>

#include "renders/kinds/delta_scene.h"
#include "renders/kinds/motor_stage_scene.h"
#include "renders/kinds/triple_z_scene.h"
#include "renders/machine_scene.h"
#include "scenarios/file_kind.h"
#include "scenarios/kinds/delta_scenario.h"
#include "scenarios/kinds/gantry_trial.h"
#include "scenarios/kinds/motor_stage_scenario.h"
#include "scenarios/kinds/triple_z_scenario.h"
#include "scenarios/kinds/z_station_scenario.h"
#include "scenarios/machine_file.h"
#include "scenarios/runner.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/kinds.h"
#include "sim/machine/kinds/triple_z/drawing.h"

namespace caltwin {

namespace fs = std::filesystem;

namespace {

/// What the file describes: a machine as its file (or extension) says it was built, or
/// the machine of a scenario with its effects and artefacts.
TwinConfig ConfigOfStill(const fs::path& file) {
  const FileKind kind = KindOf(file);
  if (kind == FileKind::kScenario) {
    const Scenario scenario = ReadScenario(file);
    if (scenario.kind.As<ZStationScenario>() != nullptr) {
      throw InputError({.file = file.string()},
                       "a nozzle's height is not drawn",
                       "models/z_station/model.xml opens in any MuJoCo viewer");
    }
    return MakeTwinConfig(scenario);
  }
  if (kind == FileKind::kMachine) {
    const MachineFile machine = ReadMachineFile(file);
    return {.machine = machine.machine,
            .effects = DrawEffects(machine.effects, /*seed=*/1, /*sample=*/0),
            .settings = machine.machine.settings};
  }
  throw InputError({.file = file.string()},
                   fmt::format("this is a {}, where a machine or a scenario is wanted",
                               ToString(kind)));
}

/// The delta that the file describes; nullopt where it is no delta.
std::optional<DeltaScene> DeltaIn(const fs::path& file, double exaggerate) {
  const FileKind kind = KindOf(file);
  if (kind == FileKind::kScenario) {
    const Scenario scenario = ReadScenario(file);
    const auto* const delta = scenario.kind.As<DeltaScenario>();
    if (delta == nullptr) return std::nullopt;
    const Machine& machine = scenario.machine.machine;
    return DeltaScene(
        machine, DrawDelta(*delta, machine, scenario.seed, /*sample=*/0), exaggerate);
  }
  if (kind != FileKind::kMachine) return std::nullopt;
  const MachineFile read = ReadAnyMachineFile(file);
  if (read.machine.kind != DeltaKind()) return std::nullopt;
  const DrawnDelta drawn =
      DrawDelta({.effects = read.effects}, read.machine, /*seed=*/1, /*sample=*/0);
  return DeltaScene(read.machine, drawn.built, exaggerate);
}

/// The triple-Z printer that the file describes; nullopt where it is none.
std::optional<TripleZScene> TripleZIn(const fs::path& file, double exaggerate) {
  const FileKind kind = KindOf(file);
  if (kind == FileKind::kScenario) {
    const Scenario scenario = ReadScenario(file);
    const auto* const triple_z = scenario.kind.As<TripleZScenario>();
    if (triple_z == nullptr) return std::nullopt;
    return TripleZScene(DrawTripleZ(*triple_z,
                                    scenario.machine.machine,
                                    scenario.seed,
                                    /*sample=*/0),
                        exaggerate);
  }
  if (kind != FileKind::kMachine) return std::nullopt;
  const MachineFile read = ReadAnyMachineFile(file);
  if (read.machine.Own<TripleZDrawing>() == nullptr) return std::nullopt;
  return TripleZScene({.machine = read.machine,
                       .effects = DrawEffects(read.effects, /*seed=*/1, /*sample=*/0)},
                      exaggerate);
}

/// The motor stage that the file describes; nullopt where it is none.
std::optional<MotorStageScene> MotorStageIn(const fs::path& file, double exaggerate) {
  if (KindOf(file) == FileKind::kScenario) {
    const Scenario scenario = ReadScenario(file);
    const auto* const motor = scenario.kind.As<MotorStageScenario>();
    if (motor == nullptr) return std::nullopt;
    return MotorStageScene(DrawMotorStage(*motor, scenario.seed, /*sample=*/0),
                           exaggerate);
  }
  if (KindOf(file) != FileKind::kMachine) return std::nullopt;
  const Machine machine = ReadAnyMachineFile(file).machine;
  if (machine.kind != MotorStageKind()) return std::nullopt;
  return MotorStageScene(DrawMotorStage({.drawing = MotorStageOf(machine)},
                                        /*seed=*/1,
                                        /*sample=*/0),
                         exaggerate);
}

template <typename Scene>
Still Held(Scene scene) {
  const auto held = std::make_shared<Scene>(std::move(scene));
  Still still{.scene = held, .model = held->model(), .data = held->data()};
  if constexpr (requires(Vec3<double> tip_mm) { held->MoveTo(tip_mm); }) {
    still.move_to = [raw = held.get()](const Vec3<double>& tip_mm) {
      using Result = decltype(raw->MoveTo(tip_mm));
      if constexpr (std::is_same_v<Result, bool>) return raw->MoveTo(tip_mm);
      raw->MoveTo(tip_mm);
      return true;
    };
  }
  return still;
}

}  // namespace

Still StillOf(const fs::path& file, double exaggerate) {
  if (auto stage = MotorStageIn(file, exaggerate)) return Held(*std::move(stage));
  if (auto delta = DeltaIn(file, exaggerate)) return Held(*std::move(delta));
  if (auto triple_z = TripleZIn(file, exaggerate)) return Held(*std::move(triple_z));
  return Held(MachineScene(ConfigOfStill(file), exaggerate));
}

}  // namespace caltwin

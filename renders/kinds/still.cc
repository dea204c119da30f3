#include "renders/kinds/still.h"

#include <algorithm>
#include <type_traits>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "renders/kinds/delta_scene.h"
#include "renders/kinds/motor_stage_scene.h"
#include "renders/kinds/triple_z_scene.h"
#include "renders/kinds/z_station_scene.h"
#include "renders/machine_scene.h"
#include "scenarios/file_kind.h"
#include "scenarios/kinds/delta_scenario.h"
#include "scenarios/kinds/gantry_trial.h"
#include "scenarios/kinds/motor_stage_scenario.h"
#include "scenarios/kinds/triple_z_scenario.h"
#include "scenarios/kinds/z_station_scenario.h"
#include "scenarios/machine_file.h"
#include "scenarios/runner.h"
#include "sim/base/input_error.h"
#include "sim/kinds/z_station/machine.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/kinds.h"
#include "sim/machine/kinds/triple_z/drawing.h"
#include "sim/machine/kinds/z_station/drawing.h"

namespace caltwin {

namespace fs = std::filesystem;

namespace {

using Travel = std::array<std::array<double, 2>, 3>;

Travel TravelOf(const Machine& machine) {
  Travel travel_mm;
  for (const Axis axis : kAxes) {
    travel_mm[Index(axis)] = {machine.axis(axis).min_mm, machine.axis(axis).max_mm};
  }
  return travel_mm;
}

// A delta's axes are its towers'.
Travel TravelOf(const DeltaDrawing& delta) {
  const double radius_mm = delta.print_radius_mm;
  return {{{-radius_mm, radius_mm},
           {-radius_mm, radius_mm},
           {0, *std::ranges::min_element(delta.model.endstop_mm)}}};
}

template <typename Scene>
Still Held(const std::string& machine, const Travel& travel_mm, Scene scene) {
  const auto held = std::make_shared<Scene>(std::move(scene));
  Still still{.machine = machine,
              .travel_mm = travel_mm,
              .scene = held,
              .model = held->model(),
              .data = held->data()};
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

Still GantryStill(const TwinConfig& config, double exaggerate) {
  return Held(
      config.machine.name, TravelOf(config.machine), MachineScene(config, exaggerate));
}

Still DeltaStill(const Machine& machine, const BuiltDelta& built, double exaggerate) {
  return Held(
      machine.name, TravelOf(DeltaOf(machine)), DeltaScene(machine, built, exaggerate));
}

Still TripleZStill(const BuiltTripleZ& built, double exaggerate) {
  return Held(
      built.machine.name, TravelOf(built.machine), TripleZScene(built, exaggerate));
}

Still StationStill(const Machine& machine,
                   const ZStationDrawing& drawing,
                   const ZStationBuild& build,
                   double exaggerate) {
  return Held(
      machine.name, TravelOf(machine), ZStationScene(drawing, build, exaggerate));
}

// On whatever machine it stands.
Still StationStill(const ZStationScenario& scenario,
                   const Machine& machine,
                   std::uint64_t seed,
                   double exaggerate) {
  ZStation station;
  SetStation(scenario.station, seed, /*sample=*/0, &station);
  const ZStationDrawing drawing{.bed_at_mm = scenario.settings.middle_mm};
  const ZStationTwin twin(
      station, /*is_physics=*/false, seed, /*sample=*/0, drawing.bed_at_mm);
  return StationStill(machine, drawing, twin.BuildAt(drawing.bed_at_mm), exaggerate);
}

Still MotorStill(const Machine& machine,
                 const BuiltMotorStage& built,
                 double exaggerate) {
  return Held(machine.name, TravelOf(machine), MotorStageScene(built, exaggerate));
}

Still MotorStillOf(const TwinFiles& twin, const Machine& machine, double exaggerate) {
  const MotorStageDrawing drawing = MotorStageOf(machine);
  const MotorStageTruth truth = twin.truth.empty()
                                    ? MotorStageTruth{.drawing = drawing}
                                    : ReadMotorTruthFile(twin.truth, drawing);
  return MotorStill(
      machine, DrawMotorStage(truth, twin.seed, /*sample=*/0), exaggerate);
}

Still DeltaStillOf(const TwinFiles& twin, const MachineFile& file, double exaggerate) {
  DeltaEffects truth;
  if (!twin.truth.empty()) truth = ReadDeltaTruthFile(twin.truth, file.machine);
  truth.effects.insert(truth.effects.end(), file.effects.begin(), file.effects.end());
  const DrawnDelta drawn = DrawDelta(truth, file.machine, twin.seed, /*sample=*/0);
  return DeltaStill(file.machine, drawn.built, exaggerate);
}

}  // namespace

Still StillOf(const TwinFiles& twin, double exaggerate) {
  MachineFile read = ReadAnyMachineFile(twin.machine);
  const Machine& machine = read.machine;
  if (machine.kind == MotorStageKind()) return MotorStillOf(twin, machine, exaggerate);
  if (machine.kind == DeltaKind()) return DeltaStillOf(twin, read, exaggerate);
  if (!twin.truth.empty()) {
    const TruthFile truth = ReadTruthFile(twin.truth, machine);
    read.effects.insert(read.effects.end(), truth.effects.begin(), truth.effects.end());
  }
  const std::vector<Injected> effects =
      DrawEffects(read.effects, twin.seed, /*sample=*/0);
  if (const auto* const drawing = machine.Own<ZStationDrawing>()) {
    return StationStill(machine, *drawing, BuildOf(machine, effects), exaggerate);
  }
  if (machine.Own<TripleZDrawing>() != nullptr) {
    return TripleZStill({.machine = machine, .effects = effects}, exaggerate);
  }
  const Machine gantry = ReadMachineFile(twin.machine).machine;
  return GantryStill({.machine = gantry,
                      .effects = effects,
                      .settings = gantry.settings,
                      .artefacts = twin.artefacts},
                     exaggerate);
}

Still StillOf(const Scenario& scenario, std::uint64_t seed, double exaggerate) {
  const Machine& machine = scenario.machine.machine;
  const AnyKindScenario& kind = scenario.kind;
  if (const auto* const station = kind.As<ZStationScenario>()) {
    return StationStill(*station, machine, seed, exaggerate);
  }
  if (const auto* const motor = kind.As<MotorStageScenario>()) {
    return MotorStill(machine, DrawMotorStage(*motor, seed, /*sample=*/0), exaggerate);
  }
  if (const auto* const delta = kind.As<DeltaScenario>()) {
    return DeltaStill(
        machine, DrawDelta(*delta, machine, seed, /*sample=*/0), exaggerate);
  }
  if (const auto* const triple_z = kind.As<TripleZScenario>()) {
    return TripleZStill(DrawTripleZ(*triple_z, machine, seed, /*sample=*/0),
                        exaggerate);
  }
  return GantryStill(MakeTwinConfig(scenario, {.seed = seed}), exaggerate);
}

Enlarged EnlargedStillOf(const Scenario& scenario,
                         std::uint64_t seed,
                         double exaggerate) {
  for (;; exaggerate = std::max(exaggerate / 2, 1.0)) {
    try {
      return {StillOf(scenario, seed, exaggerate), exaggerate};
    } catch (const InputError&) {
      if (exaggerate <= 1) throw;
    }
  }
}

Still StillOf(const fs::path& file, double exaggerate) {
  const FileKind kind = KindOf(file);
  if (kind == FileKind::kMachine)
    return StillOf(TwinFiles{.machine = file}, exaggerate);
  if (kind != FileKind::kScenario) {
    throw InputError(
        {.file = file.string()},
        fmt::format("this is a {}, where a machine or a scenario is wanted",
                    ToString(kind)));
  }
  const Scenario scenario = ReadScenario(file);
  return StillOf(scenario, scenario.seed, exaggerate);
}

}  // namespace caltwin

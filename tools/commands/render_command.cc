#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

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
#include "tools/commands/command.h"
#include "tools/commands/spare_files.h"

namespace caltwin {

namespace fs = std::filesystem;

namespace {

constexpr int kLeastPixels = 16, kMostPixels = 4096;
constexpr double kMostExaggeration = 1e6;

struct Options {
  std::string file{};
  std::string out{};
  std::string camera{};
  double exaggerate = 1;
  int width = 1280;
  int height = 960;
};

/// What the file describes: a machine as its file (or extension) says it was built, or
/// the machine of a scenario with its effects and artefacts.
TwinConfig ConfigOf(const fs::path& file) {
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

void CheckCamera(const mjModel* model, const std::string& camera) {
  if (camera.empty() || HasCamera(model, camera)) return;
  throw InputError({.file = "--camera"},
                   fmt::format("the model has no camera '{}'", camera),
                   fmt::format("it has: {}", fmt::join(CameraNames(model), ", ")));
}

/// The delta that the file describes; nullopt where it is no delta.
std::optional<DeltaScene> DeltaOf(const Options& options) {
  const fs::path file = options.file;
  const FileKind kind = KindOf(file);
  if (kind == FileKind::kScenario) {
    const Scenario scenario = ReadScenario(file);
    const auto* const delta = scenario.kind.As<DeltaScenario>();
    if (delta == nullptr) return std::nullopt;
    const Machine& machine = scenario.machine.machine;
    return DeltaScene(machine,
                      DrawDelta(*delta, machine, scenario.seed, /*sample=*/0),
                      options.exaggerate);
  }
  if (kind != FileKind::kMachine) return std::nullopt;
  const MachineFile read = ReadAnyMachineFile(file);
  if (read.machine.kind != DeltaKind()) return std::nullopt;
  const DrawnDelta drawn =
      DrawDelta({.effects = read.effects}, read.machine, /*seed=*/1, /*sample=*/0);
  return DeltaScene(read.machine, drawn.built, options.exaggerate);
}

/// The triple-Z printer that the file describes; nullopt where it is none.
std::optional<TripleZScene> TripleZOf(const Options& options) {
  const fs::path file = options.file;
  const FileKind kind = KindOf(file);
  if (kind == FileKind::kScenario) {
    const Scenario scenario = ReadScenario(file);
    const auto* const triple_z = scenario.kind.As<TripleZScenario>();
    if (triple_z == nullptr) return std::nullopt;
    return TripleZScene(DrawTripleZ(*triple_z,
                                    scenario.machine.machine,
                                    scenario.seed,
                                    /*sample=*/0),
                        options.exaggerate);
  }
  if (kind != FileKind::kMachine) return std::nullopt;
  const MachineFile read = ReadAnyMachineFile(file);
  if (read.machine.kind != TripleZKind()) return std::nullopt;
  return TripleZScene({.machine = read.machine,
                       .effects = DrawEffects(read.effects, /*seed=*/1, /*sample=*/0)},
                      options.exaggerate);
}

/// The motor stage that the file describes; nullopt where it is none.
std::optional<MotorStageScene> MotorStageOf(const Options& options) {
  const fs::path file = options.file;
  if (KindOf(file) == FileKind::kScenario) {
    const Scenario scenario = ReadScenario(file);
    const auto* const motor = scenario.kind.As<MotorStageScenario>();
    if (motor == nullptr) return std::nullopt;
    return MotorStageScene(DrawMotorStage(*motor, scenario.seed, /*sample=*/0),
                           options.exaggerate);
  }
  if (!IsMotorStage(file)) return std::nullopt;
  return MotorStageScene(DrawMotorStage({.drawing = ReadMotorStage(file)},
                                        /*seed=*/1,
                                        /*sample=*/0),
                         options.exaggerate);
}

void Draw(const Options& options, const mjModel* model, mjData* data) {
  CheckCamera(model, options.camera);
  WritePng(options.out,
           DrawScene(model,
                     data,
                     {.width = options.width,
                      .height = options.height,
                      .camera = options.camera}));
  std::cout << fmt::format("picture: {}\n", options.out);
}

int Render(const Options& options) {
  if (fs::path(options.out).extension() != ".png") {
    throw InputError({.file = "--out"},
                     fmt::format("'{}' does not end in .png", options.out),
                     "pictures are PNG files");
  }
  RefuseOverwriting({{"the file", options.file}}, {{"--out", options.out}});
  if (const auto stage = MotorStageOf(options)) {
    Draw(options, stage->model(), stage->data());
    return kPassed;
  }
  if (const auto delta = DeltaOf(options)) {
    Draw(options, delta->model(), delta->data());
    return kPassed;
  }
  if (const auto triple_z = TripleZOf(options)) {
    Draw(options, triple_z->model(), triple_z->data());
    return kPassed;
  }
  const MachineScene scene(ConfigOf(options.file), options.exaggerate);
  Draw(options, scene.model(), scene.data());
  return kPassed;
}

}  // namespace

Action DeclareRender(CLI::App* app) {
  auto options = std::make_shared<Options>();
  app->add_option("FILE", options->file, "a machine or a scenario (YAML)")->required();
  app->add_option("--out", options->out, "the picture to write (FILE.png)")->required();
  app->add_option("--exaggerate",
                  options->exaggerate,
                  "draw squareness, bed tilt and backlash so many times too large")
      ->check(CLI::Range(0.0, kMostExaggeration));
  app->add_option("--camera", options->camera, "a camera of the model, by name");
  app->add_option("--width", options->width, "pixels across")
      ->check(CLI::Range(kLeastPixels, kMostPixels))
      ->capture_default_str();
  app->add_option("--height", options->height, "pixels down")
      ->check(CLI::Range(kLeastPixels, kMostPixels))
      ->capture_default_str();
  app->footer("Needs no screen: OSMesa draws in memory.");
  return [options] {
    return Render(*options);
  };
}

}  // namespace caltwin

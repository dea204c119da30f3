#include "sim/machine/machine.h"

#include <algorithm>
#include <cstdlib>
#include <system_error>

#include <fmt/format.h>

#include "sim/machine/kinds/kinds.h"
#include "sim/machine/machine_kind.h"

#ifndef CALTWIN_SOURCE_DIR
#define CALTWIN_SOURCE_DIR "."
#endif

namespace caltwin {

namespace fs = std::filesystem;

namespace {

ProbeDrawing ReadProbe(YamlMap map, ProbeDrawing probe) {
  probe.tip_radius_mm = map.NumberOr("tip_radius_mm",
                                     probe.tip_radius_mm,
                                     {0.05, 20},
                                     "the radius of the ball, not its diameter");
  probe.pretravel_mm = map.NumberOr("pretravel_mm", probe.pretravel_mm, {0.001, 2});
  probe.hysteresis_mm = map.NumberOr("hysteresis_mm", probe.hysteresis_mm, {0, 2});
  if (probe.hysteresis_mm > 0 && probe.hysteresis_mm >= probe.pretravel_mm) {
    map.faults()->Add(map.place(),
                      map.path() + ": hysteresis_mm is not below pretravel_mm",
                      "the switch must release before the stylus is back at rest");
  }
  if (const auto speeds = map.Optional("speeds_mm_s")) {
    probe.speeds_mm_s = speeds->Numbers(2, {0.01, 100});
  }
  probe.overtravel_mm = map.NumberOr("overtravel_mm", 3, {0.05, 100});
  probe.stiffness_n_per_mm = map.NumberOr("stiffness_n_per_mm", 15, {0.1, 100});
  probe.disc_radius_mm = map.NumberOr("disc_radius_mm", 6, {1, 50});
  map.NoMoreKeys();
  return probe;
}

void ReadByDrive(YamlMap* map,
                 const std::string& key,
                 const DriveMap* drives,
                 Bounds bounds,
                 std::array<double, 3>* values) {
  const auto value = map->Optional(key);
  if (!value) return;
  YamlMap by_drive = value->Map();
  for (int i = 0; i < 3; ++i) {
    if (const auto number = by_drive.Optional(DriveName(drives, i))) {
      (*values)[static_cast<std::size_t>(i)] = number->Number(bounds);
    }
  }
  by_drive.NoMoreKeys();
}

fs::path SourceFolder() {
  return CALTWIN_SOURCE_DIR;
}

}  // namespace

bool WeightKeepsGapShut(Axis axis, const AxisDrawing& drawing) {
  if (axis != Axis::kZ) return false;
  const double hanging_n =
      drawing.moving_mass_kg * kGravity_m_s2 - drawing.counterbalance_n;
  return std::abs(hanging_n) > drawing.rail_friction_n;
}

void ReadSettings(YamlMap* map, const MachineKind& kind, Settings* settings) {
  const DriveMap* drives = kind.drive_map();
  ReadByDrive(map, "steps_per_mm", drives, {1e-3, 1e7}, &settings->steps_per_mm);
  ReadByDrive(map, "backlash_mm", drives, {0, 10}, &settings->backlash_mm);
  ReadByDrive(
      map, "probe_deflection_mm", nullptr, {-10, 10}, &settings->probe_deflection_mm);
  settings->tip_radius_mm =
      map->NumberOr("tip_radius_mm", settings->tip_radius_mm, {0, 50});
  map->NoMoreKeys();
}

namespace {

// What strangers send may name a file beside it, and no other of this computer.
void RequireBeside(const fs::path& named, const fs::path& file, const Place& place) {
  if (std::getenv("CALTWIN_CONFINED") == nullptr) return;
  std::error_code error;
  const bool climbs = std::ranges::find(named, "..") != named.end();
  if (!named.is_absolute() && !climbs && !fs::is_symlink(file, error)) return;
  throw InputError(place,
                   "only a machine by its name, or a file that was sent along, can be "
                   "named here");
}

}  // namespace

Machine ReadMachine(YamlMap* map) {
  Machine machine;
  machine.file = map->file();
  map->IntegerOr("format", 1, 1, 1);
  machine.name = map->TextOr("name", machine.file.stem().string());
  if (const auto kinematics = map->Required("kinematics")) {
    const std::vector<std::string> names = MachineKindNames();
    std::string name = kinematics->Word(names);
    if (name != kinematics->AsWritten()) {
      // As what it is meant to be; what a file of no kind says, nobody can judge.
      name = NearestWord(kinematics->AsWritten(), names);
      if (name.empty()) map->faults()->ThrowIfAny();
    }
    machine.kind = MachineKindNamed(name);
    machine.kind->ReadDrawing(map, &machine);
  }
  if (const auto model = map->Optional("model")) {
    machine.model = machine.file.parent_path() / model->Text();
    RequireBeside(model->Text(), machine.model, model->place());
    std::error_code error;
    if (!fs::is_regular_file(machine.model, error)) {
      model->Fail(fmt::format("= '{}': there is no such file", model->Text()),
                  "a path is relative to the machine file");
    }
  }
  machine.kind->ReadAxes(map, &machine);
  if (!machine.kind->has_tip()) {
    map->NoMoreKeys();
    return machine;
  }
  machine.probe = machine.kind->ProbeAsDrawn();
  // A nozzle is flat; what hangs beside it may have a ball.
  if (machine.kind->touches_with_nozzle()) machine.probe.tip_radius_mm = 0;
  if (const auto probe = map->Optional("probe"))
    machine.probe = ReadProbe(probe->Map(), machine.probe);
  machine.settings.tip_radius_mm = machine.probe.tip_radius_mm;
  for (const Axis axis : kAxes) {
    machine.settings.steps_per_mm[Index(axis)] = machine.axis(axis).steps_per_mm();
  }
  if (const auto settings = map->Optional("settings")) {
    YamlMap settings_map = settings->Map();
    machine.kind->ReadSettings(&settings_map, &machine);
  }
  map->NoMoreKeys();
  return machine;
}

Machine ReadMachine(const fs::path& file) {
  Faults faults;
  YamlMap map = ReadYamlFile(file, &faults);
  Machine machine = ReadMachine(&map);
  faults.ThrowIfAny();
  return machine;
}

fs::path ShareFolder() {
  std::error_code error;
  if (const char* folder = std::getenv("CALTWIN_SHARE")) return folder;
  const fs::path binary = fs::read_symlink("/proc/self/exe", error);
  fs::path installed = binary.parent_path().parent_path() / "share" / "caltwin";
  if (!error && fs::is_directory(installed, error)) return installed;
  return SourceFolder();
}

fs::path FindMachine(const std::string& name_or_path,
                     const fs::path& folder,
                     const Place& place) {
  std::error_code error;
  const bool is_path =
      name_or_path.find('/') != std::string::npos || name_or_path.ends_with(".yaml");
  if (is_path) {
    fs::path file = folder / name_or_path;
    RequireBeside(name_or_path, file, place);
    if (fs::is_regular_file(file, error)) return file;
    if (fs::is_regular_file(file / "machine.yaml", error)) return file / "machine.yaml";
    throw InputError(place,
                     fmt::format("there is no machine file '{}'", file.string()));
  }
  fs::path here = fs::path("models") / name_or_path / "machine.yaml";
  if (fs::is_regular_file(here, error)) return here;
  fs::path shared = ShareFolder() / here;
  if (fs::is_regular_file(shared, error)) return shared;
  throw InputError(
      place,
      fmt::format("there is no machine '{}'", name_or_path),
      fmt::format("looked for {} and {}; `caltwin new machine {}` makes one",
                  here.string(),
                  shared.string(),
                  name_or_path));
}

std::array<double, 3> TowerStepsPerMm(const Machine& machine) {
  return machine.settings.steps_per_mm;
}

}  // namespace caltwin

#include "sim/machine/machine.h"

#include <cstdlib>
#include <system_error>

#include <fmt/format.h>

#ifndef CALTWIN_SOURCE_DIR
#define CALTWIN_SOURCE_DIR "."
#endif

namespace caltwin {

namespace fs = std::filesystem;

namespace {

// `drawing`: what holds for what the map leaves out. Only where it has no lead of its
// own to offer must the map have one.
AxisDrawing ReadAxis(Axis axis, YamlMap map, AxisDrawing drawing, bool needs_lead) {
  drawing.min_mm = map.NumberOr("min_mm", 0, {-1e5, 1e5});
  drawing.max_mm = map.Number("max_mm", {-1e5, 1e5});
  if (drawing.max_mm <= drawing.min_mm) {
    map.faults()->Add(map.place(),
                      fmt::format("{}: max_mm = {} is not above min_mm = {}",
                                  map.path(),
                                  drawing.max_mm,
                                  drawing.min_mm));
  }
  const std::string home =
      map.WordOr("home", axis == Axis::kZ ? "max" : "min", {"min", "max"});
  drawing.home = home == "min" ? HomeEnd::kMin : HomeEnd::kMax;
  const bool has_pulley = map.Has("pulley_mm_per_rev");
  const bool has_lead = map.Has("lead_mm");
  if (has_pulley && has_lead) {
    map.faults()->Add(map.place(),
                      map.path() + " has both lead_mm and pulley_mm_per_rev",
                      "a screw has a lead, a belt a pulley: keep one");
  }
  if (has_pulley || has_lead || needs_lead) {
    drawing.is_belt = has_pulley;
    drawing.lead_mm = map.Number(has_pulley ? "pulley_mm_per_rev" : "lead_mm",
                                 {1e-3, 1e4},
                                 "travel per motor turn");
  }
  drawing.full_steps_per_rev =
      map.NumberOr("full_steps_per_rev", drawing.full_steps_per_rev, {1, 1e6});
  drawing.microsteps = map.NumberOr("microsteps", drawing.microsteps, {1, 4096});
  drawing.max_feed_mm_s =
      map.NumberOr("max_feed_mm_s", drawing.max_feed_mm_s, {1e-3, 1e4});
  drawing.acceleration_mm_s2 =
      map.NumberOr("acceleration_mm_s2", drawing.acceleration_mm_s2, {1e-3, 1e6});
  drawing.moving_mass_kg =
      map.NumberOr("moving_mass_kg", drawing.moving_mass_kg, {0.01, 1e5});
  drawing.rail_friction_n =
      map.NumberOr("rail_friction_n", drawing.rail_friction_n, {0, 1e5});
  const double weight_n = drawing.moving_mass_kg * kGravity_m_s2;
  drawing.counterbalance_n =
      axis == Axis::kZ ? map.NumberOr("counterbalance_n", weight_n, {0, 1e6}) : 0;
  map.NoMoreKeys();
  return drawing;
}

// A delta touches with its nozzle, unless a probe is stated. It does not give way; a
// nanometre keeps the quotients of Pretravel_mm finite.
ProbeDrawing NozzleAsProbe() {
  constexpr double kRigid_mm = 1e-6;
  return {.pretravel_mm = kRigid_mm, .hysteresis_mm = 0};
}

ProbeDrawing ReadProbe(YamlMap map, ProbeDrawing probe) {
  probe.tip_radius_mm = map.NumberOr(
      "tip_radius_mm", 1, {0.05, 20}, "the radius of the ball, not its diameter");
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

void ReadByAxis(YamlMap* map,
                const std::string& key,
                Bounds bounds,
                std::array<double, 3>* values) {
  const auto value = map->Optional(key);
  if (!value) return;
  YamlMap by_axis = value->Map();
  for (const Axis axis : kAxes) {
    if (const auto number = by_axis.Optional(Name(axis))) {
      (*values)[Index(axis)] = number->Number(bounds);
    }
  }
  by_axis.NoMoreKeys();
}

// A belt of 20 teeth of 2 mm, down from the endstop.
AxisDrawing TowerAxis(const DeltaDrawing& delta, std::size_t tower) {
  return {.min_mm = 0,
          .max_mm = delta.model.endstop_mm[tower] + delta.model.arm_mm[tower] / 4,
          .home = HomeEnd::kMin,
          .lead_mm = 40,
          .is_belt = true,
          .max_feed_mm_s = 200,
          .acceleration_mm_s2 = 2000,
          .moving_mass_kg = 0.15,
          .rail_friction_n = 6};
}

// Belts along x and y, and along z the screws: the nozzle over a bed of 235 mm.
void ReadTripleZAxes(YamlMap* map, Machine* machine) {
  TripleZDrawing& triple_z = *machine->triple_z;
  AxisDrawing belt{.max_mm = 235,
                   .lead_mm = 40,
                   .is_belt = true,
                   .max_feed_mm_s = 200,
                   .acceleration_mm_s2 = 3000,
                   .moving_mass_kg = 0.5,
                   .rail_friction_n = 2};
  const ScrewDrawing& first = triple_z.screws[0];
  AxisDrawing screw{.max_mm = triple_z.top_mm,
                    .home = HomeEnd::kMax,
                    .lead_mm = first.lead_mm,
                    .full_steps_per_rev = first.full_steps_per_rev,
                    .microsteps = first.microsteps,
                    .max_feed_mm_s = 20,
                    .acceleration_mm_s2 = 200,
                    .moving_mass_kg = 2,
                    .rail_friction_n = 5};
  // Nothing hangs on a gap: every screw's is in its drive.
  screw.counterbalance_n = screw.moving_mass_kg * kGravity_m_s2;
  machine->axes = {belt, belt, screw};
  if (const auto axes = map->Optional("axes")) {
    YamlMap by_axis = axes->Map();
    for (const Axis axis : kAxes) {
      AxisDrawing& read = machine->axes[static_cast<std::size_t>(Index(axis))];
      if (const auto drawing = by_axis.Optional(Name(axis))) {
        read = ReadAxis(axis, drawing->Map(), read, /*needs_lead=*/false);
      }
    }
    by_axis.NoMoreKeys();
  }
  // Commanded heights count from where the bed meets the nozzle.
  machine->axes[2].home = HomeEnd::kMax;
  triple_z.top_mm = machine->axes[2].max_mm;
}

// A cartesian machine names its axes; a delta's towers are alike but where they are
// named.
void ReadAxes(YamlMap* map, Machine* machine) {
  if (machine->triple_z) {
    ReadTripleZAxes(map, machine);
    return;
  }
  if (machine->delta) {
    for (std::size_t i = 0; i < kNumTowers; ++i) {
      machine->axes[i] = TowerAxis(*machine->delta, i);
    }
  }
  const auto axes = machine->delta ? map->Optional("axes") : map->Required("axes");
  if (!axes) return;
  YamlMap by_axis = axes->Map();
  for (const Axis axis : kAxes) {
    const std::string name = machine->delta ? TowerName(Index(axis)) : Name(axis);
    const auto drawing =
        machine->delta ? by_axis.Optional(name) : by_axis.Required(name);
    if (!drawing) continue;
    // What hangs on a tower's gap depends on the pose (TowerLoad_n).
    AxisDrawing& read = machine->axes[static_cast<std::size_t>(Index(axis))];
    read = machine->delta
               ? ReadAxis(Axis::kX, drawing->Map(), read, /*needs_lead=*/false)
               : ReadAxis(axis, drawing->Map(), {}, /*needs_lead=*/true);
  }
  by_axis.NoMoreKeys();
}

fs::path SourceFolder() {
  return CALTWIN_SOURCE_DIR;
}

}  // namespace

std::string ToString(Kinematics kinematics) {
  switch (kinematics) {
    case Kinematics::kDelta:
      return "delta";
    case Kinematics::kTripleZ:
      return "triple_z";
    case Kinematics::kZStation:
      return "z_station";
    case Kinematics::kCartesian:
      break;
  }
  return "cartesian";
}

bool WeightKeepsGapShut(Axis axis, const AxisDrawing& drawing) {
  if (axis != Axis::kZ) return false;
  const double hanging_n =
      drawing.moving_mass_kg * kGravity_m_s2 - drawing.counterbalance_n;
  return std::abs(hanging_n) > drawing.rail_friction_n;
}

double TowerLoad_n(const AxisDrawing& tower,
                   const DeltaDrawing& delta,
                   double nozzle_per_carriage) {
  return kGravity_m_s2 *
         (tower.moving_mass_kg + delta.effector_mass_kg * nozzle_per_carriage);
}

void ReadSettings(YamlMap* map, Settings* settings) {
  ReadByAxis(map, "steps_per_mm", {1e-3, 1e7}, &settings->steps_per_mm);
  ReadByAxis(map, "backlash_mm", {0, 10}, &settings->backlash_mm);
  ReadByAxis(map, "probe_deflection_mm", {-10, 10}, &settings->probe_deflection_mm);
  settings->tip_radius_mm =
      map->NumberOr("tip_radius_mm", settings->tip_radius_mm, {0, 50});
  map->NoMoreKeys();
}

Machine ReadMachine(YamlMap* map) {
  Machine machine;
  machine.file = map->file();
  map->IntegerOr("format", 1, 1, 1);
  machine.name = map->TextOr("name", machine.file.stem().string());
  if (const auto kinematics = map->Required("kinematics")) {
    if (kinematics->is_scalar() && kinematics->Text() == "motor_stage") {
      throw InputError(kinematics->place(),
                       "kinematics = motor_stage: single motors, which have no tip to "
                       "measure or to move",
                       "`caltwin run` runs their scenarios, scenarios/motor_*.yaml; "
                       "here a machine is cartesian, delta, triple_z or z_station");
    }
    const std::string word =
        kinematics->Word({"cartesian", "delta", "triple_z", "z_station"});
    if (word == "delta") {
      machine.kinematics = Kinematics::kDelta;
      machine.delta = ReadDeltaDrawing(map);
    } else if (word == "triple_z") {
      machine.kinematics = Kinematics::kTripleZ;
      machine.triple_z = ReadTripleZDrawing(map);
    } else if (word == "z_station") {
      machine.kinematics = Kinematics::kZStation;
      machine.z_station = ReadZStationDrawing(map);
    }
  }
  if (const auto model = map->Optional("model")) {
    machine.model = machine.file.parent_path() / model->Text();
    std::error_code error;
    if (!fs::is_regular_file(machine.model, error)) {
      model->Fail(fmt::format("= '{}': there is no such file", model->Text()),
                  "a path is relative to the machine file");
    }
  }
  ReadAxes(map, &machine);
  if (machine.delta) machine.probe = NozzleAsProbe();
  if (const auto probe = map->Optional("probe"))
    machine.probe = ReadProbe(probe->Map(), machine.probe);
  const bool is_printer = machine.kinematics != Kinematics::kCartesian;
  if (is_printer) machine.probe.tip_radius_mm = 0;  // Its nozzle is its tip.
  machine.settings.tip_radius_mm = machine.probe.tip_radius_mm;
  for (const Axis axis : kAxes) {
    machine.settings.steps_per_mm[Index(axis)] = machine.axis(axis).steps_per_mm();
  }
  if (const auto settings = map->Optional("settings")) {
    YamlMap settings_map = settings->Map();
    if (machine.delta) {
      ReadByTower(
          &settings_map, "steps_per_mm", {1e-3, 1e7}, &machine.settings.steps_per_mm);
      ReadDeltaSettings(&settings_map, machine.delta->model, &machine.delta->settings);
      settings_map.NoMoreKeys();
    } else {
      ReadSettings(&settings_map, &machine.settings);
    }
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

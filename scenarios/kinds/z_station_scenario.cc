#include "scenarios/kinds/z_station_scenario.h"

#include <algorithm>
#include <array>
#include <utility>

#include "scenarios/kinds/z_station_klipper_trial.h"
#include "scenarios/kinds/z_station_trial.h"
#include "sim/base/units.h"
#include "sim/effects/catalog.h"

namespace caltwin {
namespace {

struct StationKey {
  const char* key;
  Bounds bounds;
  double ZStation::*member;
};

// As the effect is bounded on every machine, micrometres in mm.
Bounds DeclaredBounds_mm(std::string_view effect, std::string_view parameter) {
  const Bounds um = DeclaredBounds(effect, parameter).value();
  return {MmFromUm(um.min), MmFromUm(um.max)};
}

const std::array kKeys = {
    StationKey{"switch_mm", {-20, 50}, &ZStation::switch_mm},
    StationKey{"nozzle_mm", {-5, 5}, &ZStation::nozzle_mm},
    StationKey{"ooze_mm", {0, 5}, &ZStation::ooze_mm},
    StationKey{"body_mm", {0, 50}, &ZStation::body_mm},
    StationKey{"trigger_mm", {-1, 5}, &ZStation::trigger_mm},
    StationKey{"plate_mm", {0, 20}, &ZStation::plate_mm},
    StationKey{"bed_slope_x_mrad",
               *DeclaredBounds("bed_tilt", "slope_x_mrad"),
               &ZStation::bed_slope_x_mrad},
    StationKey{"bed_slope_y_mrad",
               *DeclaredBounds("bed_tilt", "slope_y_mrad"),
               &ZStation::bed_slope_y_mrad},
    StationKey{"bed_bowl_mm",
               DeclaredBounds_mm("bed_bowl", "height_um"),
               &ZStation::bed_bowl_mm},
    StationKey{"dock_misses", {0, 1}, &ZStation::dock_misses},
    StationKey{"endstop_scatter_mm",
               DeclaredBounds_mm("trigger_scatter", "sd_um"),
               &ZStation::endstop_scatter_mm},
    StationKey{"probe_scatter_mm",
               DeclaredBounds_mm("trigger_scatter", "sd_um"),
               &ZStation::probe_scatter_mm},
    StationKey{"worn_mm", {0, 2}, &ZStation::worn_mm},
    StationKey{"nozzle_mm_per_k", {-0.1, 0.1}, &ZStation::nozzle_mm_per_k},
    StationKey{"bed_mm_per_k", {-0.1, 0.1}, &ZStation::bed_mm_per_k},
    StationKey{"frame_mm_per_k", {-0.1, 0.1}, &ZStation::frame_mm_per_k},
    StationKey{"surface_mm_per_k", {-0.1, 0.1}, &ZStation::surface_mm_per_k},
    StationKey{"trigger_mm_per_k", {-0.1, 0.1}, &ZStation::trigger_mm_per_k},
    StationKey{"ooze_flows_c", {0, 400}, &ZStation::ooze_flows_c}};

}  // namespace

std::vector<StationSpec> ReadStation(YamlMap map) {
  std::vector<StationSpec> specs;
  for (const StationKey& key : kKeys) {
    const auto value = map.Optional(key.key);
    if (!value) continue;
    specs.push_back({key.key, value->NumberOrDistribution(key.bounds)});
    const double* const number = std::get_if<double>(&specs.back().value);
    const bool is_yes_or_no = number && (*number == 0 || *number == 1);
    if (key.member == &ZStation::dock_misses && !is_yes_or_no) {
      value->Fail("is neither 0 nor 1", "1: the probe stays in its dock");
    }
  }
  map.NoMoreKeys();
  return specs;
}

namespace {

Eigen::Vector2d PlaceOf(const YamlValue& value) {
  const auto numbers = value.Numbers(2, {-1e4, 1e4});
  return numbers.size() == 2 ? Eigen::Vector2d(numbers[0], numbers[1])
                             : Eigen::Vector2d(0, 0);
}

BedMeshConfig ReadMesh(YamlMap map) {
  constexpr double kMostPoints = 20;
  BedMeshConfig mesh;
  if (const auto from = map.Optional("min_mm")) mesh.min_mm = PlaceOf(*from);
  if (const auto to = map.Optional("max_mm")) {
    mesh.max_mm = PlaceOf(*to);
    if ((mesh.max_mm - mesh.min_mm).minCoeff() <= 0) {
      to->Fail("is not beyond min_mm", "a mesh goes from min_mm to max_mm");
    }
  }
  if (const auto count = map.Optional("probe_count")) {
    const auto numbers = count->Numbers(2, {2, kMostPoints});
    if (numbers.size() == 2) {
      mesh.count = {static_cast<int>(numbers[0]), static_cast<int>(numbers[1])};
      if (numbers[0] != mesh.count[0] || numbers[1] != mesh.count[1]) {
        count->Fail("is no pair of whole numbers", "as in `probe_count: [7, 3]`");
      }
    }
  }
  if (map.Has("relative_reference_index")) {
    mesh.relative_reference_index = static_cast<int>(map.IntegerOr(
        "relative_reference_index", 0, 0, mesh.count[0] * mesh.count[1] - 1));
  }
  map.NoMoreKeys();
  return mesh;
}

ZCalibrationConfig ReadConfig(YamlMap map, const Machine& machine) {
  const AxisDrawing &x = machine.axis(Axis::kX), &y = machine.axis(Axis::kY);
  ZCalibrationConfig c;
  c.middle_mm = {x.mid_mm(), y.mid_mm()};
  c.least_mm = {x.min_mm, y.min_mm};
  c.most_mm = {x.max_mm, y.max_mm};
  c.position_max_mm = machine.axis(Axis::kZ).max_mm;
  if (const auto mesh = map.Optional("bed_mesh")) c.bed_mesh = ReadMesh(mesh->Map());
  if (const auto at = map.Optional("probe_bed_at_mm")) c.probe_bed_at_mm = PlaceOf(*at);
  c.probe_z_offset_mm = map.NumberOr("probe_z_offset_mm", 0, {-50, 50});
  c.position_endstop_mm = map.NumberOr("position_endstop_mm", 0, {-50, 500});
  c.switch_offset_mm = map.NumberOr("switch_offset_mm", c.switch_offset_mm, {-10, 10});
  c.samples = static_cast<int>(map.IntegerOr("samples", 3, 1, 100));
  c.samples_tolerance_mm =
      map.NumberOr("samples_tolerance_mm", c.samples_tolerance_mm, {0, 10});
  c.samples_tolerance_retries =
      static_cast<int>(map.IntegerOr("samples_tolerance_retries", 0, 0, 100));
  c.takes_median =
      map.WordOr("samples_result", "average", {"average", "median"}) == "median";
  c.probing_speed_mm_s = map.NumberOr("probing_speed_mm_s", 5, {0.1, 100});
  c.lifting_speed_mm_s = map.NumberOr("lifting_speed_mm_s", 5, {0.1, 100});
  c.retract_mm = map.NumberOr("sample_retract_dist_mm", 2, {0.1, 50});
  c.position_min_mm = map.NumberOr("position_min_mm", -5, {-50, 0});
  c.start_gcode = map.TextOr("start_gcode", "");
  c.before_switch_gcode = map.TextOr("before_switch_gcode", "ATTACH_PROBE");
  c.end_gcode = map.TextOr("end_gcode", "DETACH_PROBE");
  if (const auto most = map.Optional("max_deviation_mm")) {
    c.max_deviation_mm = most->Number({1e-6, 50});
  }
  if (const auto flag = map.Optional("is_virtual_endstop")) {
    c.is_virtual_endstop = flag->Flag();
  }
  map.NoMoreKeys();
  return c;
}

}  // namespace

void ZStationScenario::ReadKeys(YamlMap* map, Scenario* scenario) {
  const Machine& machine = scenario->machine.machine;
  if (const auto value = map->Optional("station")) station = ReadStation(value->Map());
  if (const auto value = map->Optional("settings")) {
    settings = ReadConfig(value->Map(), machine);
  } else {
    Faults none;
    settings = ReadConfig(ReadYamlText("{}", "", &none), machine);
  }
}

CalibrationStep ZStationScenario::ReadScenarioStep(const std::string& name,
                                                   YamlMap options) const {
  const std::vector<StationSpec> change = ReadStation(std::move(options));
  return {.name = name, .perform = [change](KindTrial* trial) {
            dynamic_cast<ZStationTrial&>(*trial).Change(change);
            return ProcedureResult{};
          }};
}

Expectable ZStationScenario::CanExpect() const {
  return {.parameters = {"switch_offset", "endstop_scatter", "probe_scatter"},
          .figures = {"z_offset_error_mm",
                      "first_layer_error_mm",
                      "gcode_offset_mm",
                      "switch_offset_mm"}};
}

void ZStationScenario::Vary(const std::string& /*effect*/,
                            const std::string& parameter,
                            const YamlValue& value,
                            Scenario* /*scenario*/) {
  for (const StationSpec& spec : ReadStation(value.Within(parameter))) {
    std::erase_if(station, [&](const StationSpec& had) { return had.key == spec.key; });
    station.push_back(spec);
  }
}

std::unique_ptr<KindTrial> ZStationScenario::BeginUnderKlipper(
    const Scenario& scenario, const Chance& chance) const {
  return BeginStationUnderKlipper(*this, scenario, chance);
}

std::unique_ptr<KindTrial> ZStationScenario::Begin(const Scenario& scenario,
                                                   const Chance& chance) const {
  return std::make_unique<ZStationTrial>(*this, scenario.machine.machine, chance);
}

void SetStation(const std::vector<StationSpec>& specs,
                std::uint64_t seed,
                std::uint64_t sample,
                ZStation* station) {
  for (const StationSpec& spec : specs) {
    const auto key = std::ranges::find_if(
        kKeys, [&](const StationKey& one) { return spec.key == one.key; });
    Rng rng(seed, sample, "station." + spec.key);
    station->*key->member = Draw(spec.value, &rng);
  }
}

}  // namespace caltwin

#include "sim/machine/kinds/delta/drawing.h"

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {
namespace {

void ReadTowers(YamlMap towers, DeltaModel<double>* model) {
  for (int i = 0; i < kNumTowers; ++i) {
    if (const auto tower = towers.Optional(TowerName(i))) {
      YamlMap keys = tower->Map();
      model->angle_rad[static_cast<std::size_t>(i)] = RadFromDeg(
          keys.Number("angle_deg", {-360, 720}, "counter-clockwise from +x"));
      keys.NoMoreKeys();
    }
  }
  towers.NoMoreKeys();
}

// Rods must reach from tower to effector at the middle of the bed.
void CheckReach(const YamlMap& map, const DeltaModel<double>& model) {
  for (std::size_t i = 0; i < kNumTowers; ++i) {
    if (model.arm_mm[i] > model.radius_mm[i]) continue;
    map.faults()->Add(
        map.place(),
        fmt::format("arm_length_mm = {} is not above delta_radius_mm = {}",
                    model.arm_mm[i],
                    model.radius_mm[i]),
        "a rod stands at a slant: about twice the radius is usual");
    return;
  }
}

}  // namespace

void ReadByTower(YamlMap* map,
                 const std::string& key,
                 Bounds bounds,
                 std::array<double, 3>* values) {
  const auto value = map->Optional(key);
  if (!value) return;
  if (!value->is_map()) {
    values->fill(value->Number(bounds, "a number, or one a tower: {a: , b: , c: }"));
    return;
  }
  YamlMap by_tower = value->Map();
  for (int i = 0; i < kNumTowers; ++i) {
    if (const auto number = by_tower.Optional(TowerName(i))) {
      (*values)[static_cast<std::size_t>(i)] = number->Number(bounds);
    }
  }
  by_tower.NoMoreKeys();
}

DeltaBuild<double> DeltaDrawing::Build() const {
  return {
      .model = model,
      .rod_spacing_mm = rod_spacing_mm,
      .effector_radius_mm = effector_radius_mm,
      .twist_per_angle = states_effector ? TwistPerAngle(model, effector_radius_mm) : 0,
      .joint_height_mm = joint_height_mm};
}

DeltaDrawing ReadDeltaDrawing(YamlMap* map) {
  DeltaDrawing drawing;
  if (const auto towers = map->Optional("towers")) {
    ReadTowers(towers->Map(), &drawing.model);
  }
  ReadByTower(map, "delta_radius_mm", {10, 2000}, &drawing.model.radius_mm);
  ReadByTower(map, "arm_length_mm", {20, 4000}, &drawing.model.arm_mm);
  ReadByTower(map, "endstop_mm", {1, 4000}, &drawing.model.endstop_mm);
  CheckReach(*map, drawing.model);
  drawing.rod_spacing_mm = map->NumberOr("rod_spacing_mm", 40, {1, 500});
  drawing.states_effector = map->Has("effector_radius_mm");
  drawing.effector_radius_mm = map->NumberOr("effector_radius_mm", 30, {1, 500});
  drawing.joint_height_mm = map->NumberOr("joint_height_mm", 20, {-200, 500});
  drawing.effector_mass_kg = map->NumberOr("effector_mass_kg", 0.35, {1e-3, 100});
  drawing.print_radius_mm =
      map->NumberOr("print_radius_mm", drawing.model.radius_mm[0] / 1.3, {1, 2000});
  drawing.settings = drawing.model;
  return drawing;
}

void ReadDeltaSettings(YamlMap* map,
                       const DeltaModel<double>& drawn,
                       DeltaModel<double>* settings) {
  ReadByTower(map, "delta_radius_mm", {10, 2000}, &settings->radius_mm);
  ReadByTower(map, "arm_length_mm", {20, 4000}, &settings->arm_mm);
  ReadByTower(map, "endstop_mm", {1, 4000}, &settings->endstop_mm);
  std::array<double, 3> more_deg{};
  for (std::size_t i = 0; i < 3; ++i) {
    more_deg[i] = DegFromRad(settings->angle_rad[i] - drawn.angle_rad[i]);
  }
  ReadByTower(map, "tower_angle_deg", {-20, 20}, &more_deg);
  for (std::size_t i = 0; i < 3; ++i) {
    settings->angle_rad[i] = drawn.angle_rad[i] + RadFromDeg(more_deg[i]);
  }
  CheckReach(*map, *settings);
}

double TowerLoad_n(const AxisDrawing& tower,
                   const DeltaDrawing& delta,
                   double nozzle_per_carriage) {
  return kGravity_m_s2 *
         (tower.moving_mass_kg + delta.effector_mass_kg * nozzle_per_carriage);
}

}  // namespace caltwin

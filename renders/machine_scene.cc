#include "renders/machine_scene.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include <fmt/format.h>

#include "sim/effects/acts/acts.h"
#include "sim/effects/catalog.h"
#include "sim/effects/injected.h"
#include "sim/machine/surface.h"

namespace caltwin {
namespace {

constexpr double kClearance_mm = 12;
constexpr std::array<float, 4> kSteel = {0.70f, 0.72f, 0.75f, 1.0f};

bool IsGeometric(int effect) {
  const bool edits_model = std::ranges::any_of(AllActs(), [effect](const ActOf& act) {
    return act.effect == effect && act.kind == ActKind::kEditModel;
  });
  return edits_model && EffectAt(effect).bucket != Bucket::kMeasurement;
}

Vec3<double> LostMotion_mm(const Machine& machine,
                           const std::vector<Injected>& effects) {
  Vec3<double> gaps_mm;
  for (const Axis axis : kAxes) {
    gaps_mm[Index(axis)] =
        BuiltValue(machine, effects, EffectIndex<Backlash>(), Name(axis), 0);
  }
  return gaps_mm;
}

/// Artefacts are plain boxes of no colour: gives them the model's own `artefact`
/// material, or the colour of ground steel where it has none.
void Dress(mjModel* model) {
  const int table = mj_name2id(model, mjOBJ_BODY, "table");
  const int material = mj_name2id(model, mjOBJ_MATERIAL, "artefact");
  for (int geom = 0; geom < model->ngeom; ++geom) {
    const bool is_artefact =
        model->geom_bodyid[geom] == table && model->geom_contype[geom] != 0;
    if (!is_artefact) continue;
    model->geom_matid[geom] = material;
    const float* rgba =
        material >= 0 ? model->mat_rgba + std::ptrdiff_t{4} * material : kSteel.data();
    std::copy_n(rgba, 4, model->geom_rgba + std::ptrdiff_t{4} * geom);
  }
}

World Build(const TwinConfig& config, const std::vector<Injected>& effects) {
  Mjcf mjcf = ModelOf(config.machine);
  EditModel(config.machine, effects, &mjcf);
  // A model without looks has no table to be seen either.
  int number = 0;
  if (config.machine.model.empty()) mjcf.AddSolid("table", TableOf(config.machine));
  for (const Artefact& artefact : config.artefacts) {
    for (const Solid& solid : SolidsOf(artefact)) {
      mjcf.AddSolid(fmt::format("artefact_{}", ++number), solid);
    }
  }
  ModelPtr model = mjcf.Compile(/*with_looks=*/true);
  Dress(model.get());
  return World(std::move(model), /*hanging_n=*/0);
}

}  // namespace

std::vector<Injected> Exaggerated(const Machine& machine,
                                  const std::vector<Injected>& effects,
                                  double factor) {
  std::vector<Injected> larger = effects;
  for (Injected& injected : larger) {
    if (!IsGeometric(injected.effect)) continue;
    std::vector<double> neutral(injected.values.size());
    EffectAt(injected.effect).neutral(machine, injected.axis, neutral);
    for (std::size_t i = 0; i < neutral.size(); ++i) {
      injected.values[i] = neutral[i] + factor * (injected.values[i] - neutral[i]);
    }
  }
  return larger;
}

MachineScene::MachineScene(const TwinConfig& config, double exaggerate)
    : world_(Build(config, Exaggerated(config.machine, config.effects, exaggerate))),
      lost_motion_mm_(LostMotion_mm(
          config.machine, Exaggerated(config.machine, config.effects, exaggerate))) {
  MoveTo(ShowPose_mm(config));
}

void MachineScene::MoveTo(const Vec3<double>& motors_mm) {
  const Vec3<double> rest = Vec3<double>::Zero();
  world_.Place(motors_mm, motors_mm - lost_motion_mm_ / 2, rest, rest);
  mj_forward(model(), data());
}

Vec3<double> ShowPose_mm(const TwinConfig& config) {
  const Machine& machine = config.machine;
  Vec3<double> pose_mm(machine.axis(Axis::kX).mid_mm(),
                       machine.axis(Axis::kY).mid_mm(),
                       machine.axis(Axis::kZ).min_mm);
  double top_mm = 0;
  if (!config.artefacts.empty()) {
    pose_mm.head<2>() = config.artefacts.front().at_mm.head<2>();
    for (const Solid& solid : SolidsOf(config.artefacts.front())) {
      top_mm = std::max(top_mm, solid.center_mm.z() + solid.half_mm.z());
    }
  }
  pose_mm.z() =
      std::min(machine.axis(Axis::kZ).max_mm, pose_mm.z() + top_mm + kClearance_mm);
  return pose_mm;
}

Picture MachinePicture(const TwinConfig& config,
                       double exaggerate,
                       const PictureOptions& options) {
  const MachineScene scene(config, exaggerate);
  return DrawScene(scene.model(), scene.data(), options);
}

}  // namespace caltwin

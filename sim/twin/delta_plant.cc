#include "sim/twin/delta_plant.h"

#include <cmath>

#include "sim/base/require.h"

namespace caltwin {

DeltaMjcf ModelOfDelta(const Machine& machine) {
  return DeltaMjcf::FromFile(machine.model.empty()
                                 ? ShareFolder() / "models/delta_printer/model.xml"
                                 : machine.model);
}

std::array<double, 3> TowerStepsPerMm(const Machine& machine) {
  return machine.settings.steps_per_mm;
}

DeltaWorld WorldOfDelta(const Machine& machine, const BuiltDelta& built) {
  DeltaMjcf model = ModelOfDelta(machine);
  if (built.tip.pretravel_mm > 0) {
    model.AddProbe(built.tip.off_mm);
  } else {
    model.MoveNozzle(built.tip.off_mm);
  }
  model.SetTimestep_s(TouchTimestep_s(built.tip));
  model.SetBuild(built.build);
  model.SetBed(built.bed);
  return {model.Compile(/*with_looks=*/false), built.build};
}

DeltaTwinPlant::DeltaTwinPlant(const Machine& machine,
                               const BuiltDelta& built,
                               bool is_physics,
                               std::uint64_t seed,
                               std::uint64_t sample)
    : built_(built),
      steps_per_mm_(TowerStepsPerMm(machine)),
      scatter_(seed, sample, "trigger_scatter") {
  Require(machine.delta.has_value(), "the machine is a delta");
  if (is_physics) {
    world_ = std::make_unique<DeltaWorld>(WorldOfDelta(machine, built));
  }
}

std::optional<Vec3<double>> DeltaTwinPlant::Touch(const DeltaModel<double>& settings,
                                                  double x_mm,
                                                  double y_mm) {
  const auto motors_mm =
      world_ ? TouchInPhysics(world_.get(),
                              built_.build,
                              built_.bed,
                              settings,
                              {x_mm, y_mm},
                              {.tip = built_.tip})
             : DeltaTouchMotors(
                   built_.build, built_.bed, settings, x_mm, y_mm, built_.tip);
  if (!motors_mm) return std::nullopt;
  Vec3<double> at = DeltaNozzle_mm(settings, *motors_mm);
  if (built_.scatter_mm > 0) at[2] += built_.scatter_mm * scatter_.Normal();
  Vec3<double> counted_mm = DeltaMotors_mm(settings, at);
  for (int i = 0; i < 3; ++i) {
    const double steps_per_mm = steps_per_mm_[static_cast<std::size_t>(i)];
    counted_mm[i] = std::round(counted_mm[i] * steps_per_mm) / steps_per_mm;
  }
  return counted_mm;
}

}  // namespace caltwin

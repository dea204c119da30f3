// Speed of a delta: touches in closed form and in MuJoCo, the joint estimate. Run by
// tools/bench.sh with the rest.
#include <cmath>

#include <benchmark/benchmark.h>

#include "calibration/kinds/delta/joint.h"
#include "sim/base/rng.h"
#include "sim/base/units.h"
#include "sim/kinds/delta/world.h"
#include "sim/machine/kinds/delta/knobs.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/kinds/delta/simulated.h"

namespace caltwin {
namespace {

DeltaModel<double> Drawn() {
  return SymmetricDelta(300, 130, 250);
}

std::vector<Vec3<double>> ThirtySeven() {
  std::vector<Vec3<double>> points;
  for (int i = 0; i < 37; ++i) {
    const double angle = 2.399963 * i, out_mm = 100 * std::sqrt(i / 36.0);
    points.emplace_back(out_mm * std::cos(angle), out_mm * std::sin(angle), 0);
  }
  return points;
}

std::vector<int> FirstKnobs(std::int64_t count) {
  std::vector<int> knobs = MachineKnobs();
  knobs.resize(static_cast<std::size_t>(count));
  return knobs;
}

void DeltaJoint37Touches(benchmark::State& state) {
  const std::vector<int> knobs = FirstKnobs(state.range(0));
  DeltaBuild<double> build{.model = Drawn()};
  DeltaBed<double> bed;
  Rng rng(1, 0, "bench");
  for (const int knob : knobs) {
    const DeltaKnob& is = kDeltaKnobs[static_cast<std::size_t>(knob)];
    TurnKnob(knob, 0.5 * is.prior_sd * is.per_unit * rng.Normal(), &build, &bed);
  }
  SimulatedDelta machine(build, bed, 0.005, 1);
  DeltaReadings readings;
  for (const Vec3<double>& at : ThirtySeven()) {
    const auto motors = machine.Touch(Drawn(), at[0], at[1]);
    readings.touches.push_back({*motors, 0, 0.005});
  }
  while (state.KeepRunning()) {
    benchmark::DoNotOptimize(
        FitDeltaJointly({.model = Drawn()}, readings, {.knobs = knobs}));
  }
}
BENCHMARK(DeltaJoint37Touches)->Arg(9)->Arg(27)->Unit(benchmark::kMillisecond);

// By the nozzle, and by a sprung probe with that many um of pre-travel.
void DeltaGrid37InPhysics(benchmark::State& state) {
  DeltaBuild<double> build{.model = Drawn()};
  build.rod_error_mm = {0.3, -0.2, 0.1, 0, -0.4, 0.2};
  const DeltaBed<double> bed{.slope_x = 0.002};
  const DeltaTip tip{.pretravel_mm = MmFromUm(static_cast<double>(state.range(0)))};
  DeltaMjcf model = DeltaMjcf::FromFile("models/delta_printer/model.xml");
  if (!tip.IsNozzle()) model.AddProbe(tip.off_mm);
  model.SetTimestep_s(TouchTimestep_s(tip));
  model.SetBuild(build);
  model.SetBed(bed);
  DeltaWorld world(model.Compile(/*with_looks=*/false), build);
  while (state.KeepRunning()) {
    for (const Vec3<double>& at : ThirtySeven()) {
      const auto descent = [&](double z_mm) {
        return DeltaMotors_mm<double>(Drawn(), {at[0], at[1], z_mm});
      };
      benchmark::DoNotOptimize(
          TouchInPhysics_mm(&world, build, bed, descent, /*near_mm=*/0, {.tip = tip}));
    }
  }
}
BENCHMARK(DeltaGrid37InPhysics)
    ->ArgName("pretravel_um")
    ->Arg(0)
    ->Arg(300)
    ->Arg(20)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace caltwin

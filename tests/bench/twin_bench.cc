// Speed of the twin, its parts and whole calibrations. Run by tools/bench.sh; the
// figures that count are in docs/performance.md with the command.
#include <cmath>
#include <ctime>

#include <benchmark/benchmark.h>

#include "scenarios/runner.h"
#include "sim/physics/world.h"
#include "sim/twin/fast_plant.h"
#include "sim/twin/physics_plant.h"

namespace caltwin {
namespace {

Built Gantry() {
  Artefact block{.id = "block"};
  block.at_mm = {150, 150, 0};
  Built built{.machine = ReadMachine("models/gantry_router/machine.yaml"),
              .artefacts = {block}};
  built.Prepare();
  return built;
}

// One step of MuJoCo alone, on the very model the plant steps: the floor.
void RawMujocoStep(benchmark::State& state) {
  PhysicsPlant plant(Gantry(), 1, 0);
  const mjModel* model = plant.world().model();
  mjData* data = plant.world().data();
  while (state.KeepRunning()) mj_step(model, data);
}
BENCHMARK(RawMujocoStep);

// The same with the drive's forces, the readings and the checks around it.
void WorldStep(benchmark::State& state) {
  PhysicsPlant plant(Gantry(), 1, 0);
  const Vec3<double> nuts_mm = plant.world().Nuts_mm();
  while (state.KeepRunning()) plant.world().Step(nuts_mm);
}
BENCHMARK(WorldStep);

// A measuring touch of a face at 1 mm/s and the way back, 2 mm off the face.
void Touch(TwinPlant* plant, benchmark::State& state) {
  const Built& built = plant->built();
  const Vec3<double> off = built.StepsAt({108.9, 150, 12});
  const Vec3<double> in = built.StepsAt({113, 150, 12});
  Vec3<double> at = plant->steps();
  const auto go = [&](const Vec3<double>& to, double feed_mm_s, Watch::Kind kind) {
    const double length_mm = (to - at).norm() / 800;
    const double top_mm_s = std::min(feed_mm_s, std::sqrt(300 * length_mm));
    const Segment segment{.from_steps = at,
                          .to_steps = to,
                          .profile = {.length_mm = length_mm,
                                      .feed_top_mm_s = top_mm_s,
                                      .acceleration_mm_s2 = 300}};
    const Outcome outcome = plant->Run(segment, {.kind = kind});
    at = outcome.stopped ? segment.Steps(outcome.time_s).array().round().matrix() : to;
    if (outcome.stopped) plant->Settle(at);
    return outcome.time_s;
  };
  go(built.StepsAt({100, 150, 100}), 100, Watch::Kind::kNothing);
  go(off, 40, Watch::Kind::kNothing);
  double machine_s = 0;
  const std::clock_t start = std::clock();
  while (state.KeepRunning()) {
    machine_s += go(in, 1, Watch::Kind::kProbeTriggered);
    machine_s += go(off, 40, Watch::Kind::kNothing);
  }
  state.counters["machine_s_per_cpu_s"] =
      machine_s * CLOCKS_PER_SEC / static_cast<double>(std::clock() - start);
}

void PhysicsTouch(benchmark::State& state) {
  PhysicsPlant plant(Gantry(), 1, 0);
  Touch(&plant, state);
  state.counters["steps_per_touch"] =
      static_cast<double>(plant.num_steps()) / static_cast<double>(state.iterations());
}
BENCHMARK(PhysicsTouch)->Unit(benchmark::kMillisecond);

void FastTouch(benchmark::State& state) {
  FastPlant plant(Gantry(), 1, 0);
  Touch(&plant, state);
}
BENCHMARK(FastTouch)->Unit(benchmark::kMicrosecond);

void MakeTwin(benchmark::State& state) {
  TwinConfig config{.machine = ReadMachine("models/gantry_router/machine.yaml")};
  config.settings = config.machine.settings;
  while (state.KeepRunning()) benchmark::DoNotOptimize(Twin(config));
}
BENCHMARK(MakeTwin)->Unit(benchmark::kMillisecond);

// Phases 2 to 5 on three axes, over the G-code wire: the main job.
void FirstLight(benchmark::State& state, Fidelity fidelity) {
  const Scenario scenario = ReadScenario("scenarios/first_light.yaml");
  double machine_s = 0;
  double cpu_s = 0;
  double touches = 0;
  while (state.KeepRunning()) {
    const RunResult result = RunScenario(scenario, {.fidelity = fidelity});
    machine_s += result.machine_time_s;
    cpu_s += result.cpu_s;
    touches += result.touches;
  }
  state.counters["machine_s_per_cpu_s"] = machine_s / cpu_s;
  state.counters["touches"] = touches / static_cast<double>(state.iterations());
}
BENCHMARK_CAPTURE(FirstLight, physics, Fidelity::kPhysics)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(FirstLight, fast, Fidelity::kFast)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace caltwin

BENCHMARK_MAIN();

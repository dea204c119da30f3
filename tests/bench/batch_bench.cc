// One world a worker against MuJoCo's batch of worlds, on the gantry's model and two
// threads. A closed loop must see the switch and set the drive's force after every
// step: `steps` = 1 is what caltwin needs, more are what the batch would like best.
#include <array>
#include <cstddef>
#include <cstdint>
#include <ctime>
#include <memory>
#include <thread>

#include <benchmark/benchmark.h>
#include <mujoco/mjbatch.h>

#include "sim/twin/physics_plant.h"

namespace caltwin {
namespace {

constexpr int kThreads = 2;
constexpr int kStepsAWorld = 40000;

std::unique_ptr<PhysicsPlant> Plant() {
  Artefact block{.id = "block"};
  block.at_mm = {150, 150, 0};
  Built built{.machine = ReadMachine("models/gantry_router/machine.yaml"),
              .artefacts = {block}};
  built.Prepare();
  return std::make_unique<PhysicsPlant>(built, 1, 0);
}

// CPU time of all threads since `start` over the steps of all worlds.
void CountSteps(std::int64_t steps, std::clock_t start, benchmark::State* state) {
  const double cpu_s = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  state->counters["cpu_us_per_step"] = 1e6 * cpu_s / static_cast<double>(steps);
  state->counters["steps_per_s"] =
      benchmark::Counter(static_cast<double>(steps), benchmark::Counter::kIsRate);
}

void StepMany(PhysicsPlant* plant) {
  const mjModel* model = plant->world().model();
  for (int step = 0; step < kStepsAWorld; ++step) {
    mj_step(model, plant->world().data());
  }
}

// What a study does: a world of its own for each worker.
void OwnWorlds(benchmark::State& state) {
  std::array<std::unique_ptr<PhysicsPlant>, kThreads> plants;
  for (auto& plant : plants) plant = Plant();
  std::int64_t steps = 0;
  const std::clock_t start = std::clock();
  while (state.KeepRunning()) {
    std::array<std::thread, kThreads> threads;
    for (std::size_t i = 0; i < threads.size(); ++i) {
      threads.at(i) = std::thread(StepMany, plants.at(i).get());
    }
    for (std::thread& thread : threads) thread.join();
    steps += std::int64_t{kThreads} * kStepsAWorld;
  }
  CountSteps(steps, start, &state);
}
BENCHMARK(OwnWorlds)->MeasureProcessCPUTime()->UseRealTime();

// Arguments: worlds, steps before the loop is closed, whether each keeps its data.
void BatchOfWorlds(benchmark::State& state) {
  const std::unique_ptr<PhysicsPlant> plant = Plant();
  const auto worlds = static_cast<int>(state.range(0));
  const auto at_once = static_cast<int>(state.range(1));
  mjBatchConfig config;
  mjb_defaultConfig(&config);
  config.nthread = kThreads;
  config.persistent = static_cast<mjtBool>(state.range(2) != 0);
  std::array<char, 200> error{};
  mjBatch* batch = mjb_makeBatch(
      plant->world().model(), worlds, &config, error.data(), error.size());
  if (batch == nullptr) {
    state.SkipWithError(error.data());
    return;
  }
  for (int world = 0; world < worlds; ++world) {
    mj_getState(
        plant->world().model(),
        plant->world().data(),
        mjb_state(batch) + static_cast<std::ptrdiff_t>(world) * mjb_nstate(batch),
        mjSTATE_INTEGRATION);
  }
  std::int64_t steps = 0;
  const std::clock_t start = std::clock();
  while (state.KeepRunning()) {
    const int failed = mjb_step(batch, nullptr, 0, at_once, 0);
    if (failed > 0) state.SkipWithError(mjb_error(batch, 0));
    steps += std::int64_t{worlds} * at_once;
  }
  CountSteps(steps, start, &state);
  mjb_deleteBatch(batch);
}
BENCHMARK(BatchOfWorlds)
    ->ArgNames({"worlds", "steps", "persistent"})
    ->ArgsProduct({{2, 64}, {1, 16, 256}, {0, 1}})
    ->MeasureProcessCPUTime()
    ->UseRealTime();

}  // namespace
}  // namespace caltwin

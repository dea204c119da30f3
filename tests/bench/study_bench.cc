// Speed of a study's trial: a whole calibration over the wire, and a linear one.

#include <vector>

#include <benchmark/benchmark.h>

#include "scenarios/study/study.h"

namespace caltwin {
namespace {

constexpr double kPerMinute = 60;

void FastTrial(benchmark::State& state) {
  const Study study = ReadStudy("scenarios/studies/next.yaml");
  std::int64_t trial = 0;
  while (state.KeepRunning()) {
    benchmark::DoNotOptimize(KeptOf(RunTrial(study, 0, trial), 0, trial));
    ++trial;
  }
  state.counters["per_minute_and_core"] = benchmark::Counter(
      kPerMinute * static_cast<double>(trial), benchmark::Counter::kIsRate);
}
BENCHMARK(FastTrial)->Unit(benchmark::kMillisecond);

// 60 rows, nine unknowns.
void LinearTrial(benchmark::State& state) {
  const Study study = ReadStudy("scenarios/studies/sixty_touches.yaml");
  const std::size_t unknowns = study.plan->design().unknowns.size();
  std::vector<double> about_middle(unknowns), errors(unknowns);
  std::int64_t trial = 0;
  while (state.KeepRunning()) {
    study.plan->LinearErrors(trial++, about_middle.data(), errors.data());
    benchmark::DoNotOptimize(errors.data());
  }
  state.counters["per_minute_and_core"] = benchmark::Counter(
      kPerMinute * static_cast<double>(trial), benchmark::Counter::kIsRate);
}
BENCHMARK(LinearTrial);

}  // namespace
}  // namespace caltwin

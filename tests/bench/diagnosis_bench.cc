// Speed of a diagnosis, and of the products that it is made of.

#include <cmath>
#include <numbers>

#include <Eigen/Core>
#include <benchmark/benchmark.h>

#include "calibration/diagnosis/diagnosis.h"
#include "calibration/estimate/inner_products.h"
#include "sim/base/rng.h"

namespace caltwin {
namespace {

// Two lasers, 1000 rows each, to and fro: a wave of each screw turn along x, a bend of
// the pitch along y.
RowTable TwoLasers() {
  constexpr int kRows = 1000, kPlaces = 50;
  constexpr double kWave_mm = 0.005, kBend_mm = 0.015, kLead_mm = 4, kSigma_mm = 1e-3;
  Rng rng(1, 0, "diagnosis_bench");
  RowTable table;
  for (int i = 0; i < 2 * kRows; ++i) {
    const bool is_x = i < kRows;
    const int run = i / kPlaces, step = i % kPlaces;
    const double u = std::fmod(0.5 + 0.61803398875 * step, 1.0);
    const double sense = run % 2 == 0 ? 1 : -1;
    Row row{.row = i + 1, .campaign = is_x ? "laser_x" : "laser_y"};
    row.t_s = 5 * i;
    row.rep = 1 + run % (kRows / kPlaces) / 2;
    const double q_mm = 10 + 280 * u, turn_rad = 2 * std::numbers::pi * q_mm / kLead_mm;
    const double bend = 2 * (2 * u - 1) * (2 * u - 1) - 1;
    row.cmd_mm = {is_x ? q_mm : 0, is_x ? 0 : q_mm, 0};
    row.dir = {is_x ? sense : 0, is_x ? 0 : sense, 0};
    row.n = {is_x ? 1.0 : 0.0, is_x ? 0.0 : 1.0, 0};
    row.value_mm = (is_x ? kWave_mm * std::sin(turn_rad) : kBend_mm * bend) +
                   kSigma_mm * rng.Normal();
    table.rows.push_back(row);
  }
  return table;
}

void DiagnoseTwoThousandRows(benchmark::State& state) {
  Machine machine{.name = "bench"};
  machine.settings.steps_per_mm = {800, 800, 800};
  const Observed observed(TwoLasers(), {}, machine, {});
  while (state.KeepRunning()) benchmark::DoNotOptimize(Diagnose(observed, {}));
}
BENCHMARK(DiagnoseTwoThousandRows)->Unit(benchmark::kMillisecond);

// Candidates against a baseline: range(0) columns against 130, of 2000 rows.
void ProductsOfColumns(benchmark::State& state) {
  const Eigen::MatrixXd a = Eigen::MatrixXd::Random(2000, 130);
  const Eigen::MatrixXd b = Eigen::MatrixXd::Random(2000, state.range(0));
  Eigen::MatrixXd products(a.cols(), b.cols());
  while (state.KeepRunning()) {
    InnerProducts({a.data(), a.rows(), a.cols(), a.rows()},
                  {b.data(), b.rows(), b.cols(), b.rows()},
                  products.data());
    benchmark::DoNotOptimize(products.data());
  }
  state.counters["flop"] = benchmark::Counter(
      2.0 * static_cast<double>(a.size() * b.cols() * state.iterations()),
      benchmark::Counter::kIsRate);
}
BENCHMARK(ProductsOfColumns)->Arg(2)->Arg(17)->Arg(64);

}  // namespace
}  // namespace caltwin

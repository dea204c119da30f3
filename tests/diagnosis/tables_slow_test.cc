// Tables without a formula, and the machine that is extended by them.
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "calibration/diagnosis/as_found.h"
#include "calibration/diagnosis/diagnosis.h"
#include "sim/base/rng.h"

namespace caltwin {
namespace {

constexpr double kSigma_mm = 1e-3;

// A laser along x, five times to and fro, by a screw whose error grows as a logarithm.
RowTable LogarithmicScrew(std::uint64_t seed) {
  constexpr int kRuns = 10, kPlaces = 21;
  constexpr double kError_mm = 0.010, kLength_mm = 10;
  Rng rng(seed, 0, "tables_slow_test");
  RowTable table;
  for (int i = 0; i < kRuns * kPlaces; ++i) {
    const int run = i / kPlaces, step = i % kPlaces;
    const bool is_up = run % 2 == 0;
    const int place = is_up ? step : kPlaces - 1 - step;
    const double u = std::fmod(0.5 + 0.61803398875 * place, 1.0);
    Row row{.row = i + 1, .campaign = "laser"};
    row.t_s = 5 * i;
    row.rep = 1 + run / 2;
    row.cmd_mm = {8 + 14.2 * place + 3 * (u - 0.5), 0, 0};
    row.dir = {is_up ? 1.0 : -1.0, 0, 0};
    row.n = {1, 0, 0};
    row.value_mm =
        kError_mm * std::log(1 + row.cmd_mm[0] / kLength_mm) + kSigma_mm * rng.Normal();
    table.rows.push_back(row);
  }
  return table;
}

// What a table's prior held back would be found in the extended machine, as a change of
// pitch.
TEST(Tables, LeaveNothingToFindInTheExtendedMachine) {
  Machine machine{.name = "test"};
  machine.settings.steps_per_mm = {800, 800, 800};
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Observed observed(LogarithmicScrew(seed), {}, machine, {});
    const Diagnosis found = Diagnose(observed, {});
    ASSERT_EQ(found.findings.size(), 1U);
    ASSERT_TRUE(found.findings[0].map);
    const auto table = EffectOf(found.findings[0]);
    ASSERT_TRUE(table);

    const Diagnosis again = Diagnose(observed.With({*table}), {});

    EXPECT_EQ(ToString(again.verdict), "none") << "seed " << seed;
  }
}

}  // namespace
}  // namespace caltwin

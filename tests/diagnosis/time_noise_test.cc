// How sure sizes are beside noise that hangs together in time: the stated intervals are
// counted over machines whose truth is known.
#include "calibration/diagnosis/time_noise.h"

#include <cmath>

#include <gtest/gtest.h>

#include "sim/base/rng.h"

namespace caltwin {
namespace {

constexpr double kSigma_mm = 1e-3;
constexpr Eigen::Index kRows = 160;
constexpr double kOf95_sd = 1.96;

Machine Plain() {
  Machine machine{.name = "test"};
  machine.settings.steps_per_mm = {800, 800, 800};
  return machine;
}

// Readings at one place; their noise is an autoregression of the first order with unit
// variance, `phi` from row to row, times sigma.
RowTable Readings(double phi, std::uint64_t seed) {
  Rng rng(seed, 0, "time_noise_test");
  RowTable table;
  double noise = rng.Normal();
  for (Eigen::Index i = 0; i < kRows; ++i) {
    Row row{.row = i + 1, .campaign = "place"};
    row.t_s = static_cast<double>(20 * i);
    row.cmd_mm = {100, 0, 0};
    row.dir = {1, 0, 0};
    row.n = {1, 0, 0};
    row.value_mm = kSigma_mm * noise;
    table.rows.push_back(row);
    noise = phi * noise + std::sqrt(1 - phi * phi) * rng.Normal();
  }
  return table;
}

// An offset, and a temperature that rises once and settles.
std::vector<Nuisance> OffsetAndWarming() {
  Eigen::VectorXd warmth(kRows);
  for (Eigen::Index i = 0; i < kRows; ++i) {
    warmth[i] = 1 - std::exp(-4 * static_cast<double>(i) / kRows);
  }
  return {{.name = "offset", .column_mm = Eigen::VectorXd::Ones(kRows), .prior_sd = 1},
          {.name = "warming", .column_mm = warmth, .prior_sd = 1}};
}

struct Counted {
  int plain = 0, in_time = 0;
};

// Of `machines`, in how many the truth (no warming at all) lies within 1.96 sd.
Counted Covered(double phi, int machines) {
  const std::vector<Nuisance> nuisances = OffsetAndWarming();
  const Noise noise{Eigen::VectorXd::Constant(kRows, kSigma_mm), 0};
  Counted counted;
  for (int machine = 0; machine < machines; ++machine) {
    const Observed observed(
        Readings(phi, static_cast<std::uint64_t>(machine)), {}, Plain(), {});
    const Evidence::Fit fit = Evidence(observed, noise, nuisances).FitNuisances();
    const double spread = TimeNoise(observed, noise, nuisances).of_nuisances()[1];
    counted.plain += std::abs(fit.values[1]) < kOf95_sd * fit.sds[1] ? 1 : 0;
    counted.in_time += std::abs(fit.values[1]) < kOf95_sd * spread * fit.sds[1] ? 1 : 0;
  }
  return counted;
}

// 95 % of 200 less three standard deviations of that count (3.1 each); above, a band as
// wide that it may be too careful by.
TEST(TimeNoise, IntervalsCoverBesideAWander) {
  const Counted counted = Covered(0.9, 200);

  RecordProperty("covered", counted.in_time);
  RecordProperty("covered_if_rows_were_independent", counted.plain);
  EXPECT_LT(counted.plain, 130);
  EXPECT_GE(counted.in_time, 180);
  EXPECT_LE(counted.in_time, 199);
}

TEST(TimeNoise, LeavesWhiteNoiseAlone) {
  const Counted counted = Covered(0, 200);

  EXPECT_NEAR(counted.in_time, counted.plain, 2);
  EXPECT_GE(counted.in_time, 180);
}

TEST(TimeNoise, TheMeanOfAWanderIsAsUnsureAsItsSum) {
  constexpr double kPhi = 0.9;
  constexpr int kMachines = 30;
  const std::vector<Nuisance> nuisances = {OffsetAndWarming()[0]};
  const Noise noise{Eigen::VectorXd::Constant(kRows, kSigma_mm), 0};
  double sum = 0;
  for (std::uint64_t machine = 0; machine < kMachines; ++machine) {
    const Observed observed(Readings(kPhi, machine), {}, Plain(), {});
    sum += TimeNoise(observed, noise, nuisances).of_nuisances()[0];
  }

  // (1 + phi) / (1 - phi) times the variance in the limit of many rows.
  const double inflation = std::sqrt((1 + kPhi) / (1 - kPhi));
  EXPECT_NEAR(sum / kMachines, inflation, 0.25 * inflation);
}

}  // namespace
}  // namespace caltwin

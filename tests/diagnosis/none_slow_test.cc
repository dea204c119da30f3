// "Nothing but noise" is said only where that is so.

#include <cmath>
#include <functional>
#include <numbers>

#include <gtest/gtest.h>

#include "calibration/diagnosis/diagnosis.h"
#include "sim/base/rng.h"

namespace caltwin {
namespace {

// A laser along x at so many places, once or several times, in one sense: `error_um` of
// the place and 0.5 um of noise.
Diagnosis DiagnosisOf(int places,
                      int runs,
                      const std::function<double(double)>& error_um,
                      double min_effect_um = 0,
                      bool has_times = true) {
  Machine machine;
  for (const Axis axis : kAxes) {
    machine.settings.steps_per_mm[Index(axis)] = machine.axis(axis).steps_per_mm();
  }
  RowTable table;
  Rng rng(1, 0, "none");
  for (int i = 0; i < places * runs; ++i) {
    // Without times in no order, else blocks of rows would be parts of the travel.
    const int place = (has_times ? i : 37 * i) % places;
    const double q_mm = 10 + 280.0 * place / (places - 1) + 0.37 * (place % 3);
    Row row{.row = i + 1, .campaign = "laser", .kind = RowKind::kPosition};
    if (has_times) row.t_s = 12.0 * i;
    if (has_times) row.rep = 1 + i / places;
    row.n = {1, 0, 0};
    row.cmd_mm = {q_mm, 150, 50};
    row.dir = {1, 0, 0};
    row.value_mm = 1e-3 * (error_um(q_mm) + 0.5 * rng.Normal());
    row.sigma_mm = 0.0005;
    table.rows.push_back(row);
  }
  return Diagnose(Observed(table, {}, machine, {}), {.min_effect_um = min_effect_um});
}

double BentAndWavy(double q_mm) {
  const double u = (q_mm - 150) / 150;
  return 20 * u * u + 5 * std::sin(2 * std::numbers::pi * q_mm / 4);
}

TEST(None, IsNotSaidOfFewRowsThatAreFarFromNoise) {
  for (const int places : {10, 24}) {
    EXPECT_NE(DiagnosisOf(places, 1, BentAndWavy).verdict, DiagnosisVerdict::kNone)
        << places;
  }
  const auto step = [](double q_mm) {
    return q_mm > 140 ? 50.0 : 0.0;
  };
  EXPECT_NE(DiagnosisOf(41, 2, step).verdict, DiagnosisVerdict::kNone);
  EXPECT_NE(DiagnosisOf(21, 1, step).verdict, DiagnosisVerdict::kNone);
}

TEST(None, IsSaidOfNoise) {
  for (const int places : {10, 24, 41}) {
    EXPECT_EQ(DiagnosisOf(places, 1, [](double) { return 0.0; }).verdict,
              DiagnosisVerdict::kNone)
        << places;
  }
}

// A wave too fine for a table's terms and of no part's period: repeats show that it is
// no wander, so "nothing but noise" would be untrue.
TEST(None, IsNotSaidOfWhatComesBackWhereTheSameIsMeasuredAgain) {
  const auto wave = [](double q_mm) {
    return 6 * std::sin(2 * std::numbers::pi * q_mm / 31.7);
  };
  EXPECT_NE(DiagnosisOf(21, 6, wave).verdict, DiagnosisVerdict::kNone);
}

// Neither times nor repeats: what is within twice the noise may be a wander; what is
// far beyond it is not called noise.
TEST(None, WithoutTimesATableMayBeWander) {
  const auto smooth_um = [](double height_um) {
    return [height_um](double q_mm) {
      return height_um * std::sin(2 * std::numbers::pi * q_mm / 130);
    };
  };
  const auto verdict = [&](double height_um, int runs) {
    return DiagnosisOf(80, runs, smooth_um(height_um), 0, /*has_times=*/false).verdict;
  };
  EXPECT_EQ(verdict(0.9, 1), DiagnosisVerdict::kNone);
  EXPECT_NE(verdict(0.9, 2), DiagnosisVerdict::kNone);
  EXPECT_NE(verdict(8, 1), DiagnosisVerdict::kNone);
}

// A wave of 4 um that is not asked for may not come back as a table of 15.
TEST(None, WhatIsTooSmallToReportHidesNothing) {
  const auto wave = [](double q_mm) {
    return 4 * std::sin(2 * std::numbers::pi * q_mm / 4);
  };
  ASSERT_EQ(DiagnosisOf(60, 2, wave).verdict, DiagnosisVerdict::kNamed);
  EXPECT_EQ(DiagnosisOf(60, 2, wave, /*min_effect_um=*/5).verdict,
            DiagnosisVerdict::kNone);
}

TEST(None, BelowTheSizeAskedForIsSaid) {
  const Diagnosis diagnosis = DiagnosisOf(24, 3, BentAndWavy, /*min_effect_um=*/60);
  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kNone);
  EXPECT_EQ(diagnosis.min_effect_um, 60);
}

}  // namespace
}  // namespace caltwin

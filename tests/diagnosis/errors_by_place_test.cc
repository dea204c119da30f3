#include "calibration/diagnosis/errors_by_place.h"

#include <cmath>

#include <gtest/gtest.h>

#include "calibration/diagnosis/diagnosis.h"
#include "sim/base/rng.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kGap_um = 40, kSigma_um = 0.5;
constexpr int kPositions = 12, kRounds = 2;

// A laser along x, both ways; the axis loses a gap at each reversal.
Observed GappyAxis() {
  Rng rng(4, 0, "errors_by_place_test");
  RowTable table;
  for (int i = 0; i < 2 * kRounds * kPositions; ++i) {
    const int at = i % kPositions;
    const bool is_forward = (i / kPositions) % 2 == 0;
    Row row{.row = i + 1, .campaign = "moves"};
    row.cmd_mm = {10.0 * (is_forward ? at : kPositions - 1 - at), kUnknown, kUnknown};
    row.dir = {is_forward ? 1.0 : -1.0, 0, 0};
    row.n = {1, 0, 0};
    row.sigma_mm = MmFromUm(kSigma_um);
    row.value_mm =
        MmFromUm((is_forward ? -1 : 1) * kGap_um / 2 + kSigma_um * rng.Normal());
    table.rows.push_back(row);
  }
  Machine machine{.name = "test"};
  machine.settings.steps_per_mm = {800, 800, 800};
  return {table, {}, machine, {}};
}

TEST(ErrorsByPlace, LostMotionIsHalfTheGapOnEitherSide) {
  const Observed observed = GappyAxis();

  const auto errors = ErrorsByPlace(observed, Diagnose(observed, {}));

  ASSERT_EQ(errors.size(), 2U * kPositions);
  for (const ErrorAtPlace& one : errors) {
    EXPECT_EQ(one.rows, kRounds);
    EXPECT_NEAR(one.fitted_um, -one.sense * kGap_um / 2, 4 * kSigma_um);
    EXPECT_TRUE(std::isnan(one.cmd_mm[1]));  // Nobody told: not made up.
  }
}

TEST(ErrorsByPlace, WhatWasLeftOutIsNotCounted) {
  const Observed observed = GappyAxis();
  Diagnosis diagnosis = Diagnose(observed, {});
  diagnosis.outlier_rows = {1, 1 + 2 * kPositions};  // Both of the first place.

  const auto errors = ErrorsByPlace(observed, diagnosis);

  EXPECT_EQ(errors.size(), 2U * kPositions - 1);
}

}  // namespace
}  // namespace caltwin

#include "calibration/diagnosis/noise.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

namespace caltwin {
namespace {

constexpr int kReadings = 12;
constexpr double kStep_mm = 0.001;  // What drifts from one reading to the next.

// One place read again and again while the frame creeps, listed out of order.
Observed Creeping(bool has_times) {
  Machine machine{.name = "test"};
  machine.settings.steps_per_mm = {800, 800, 800};
  RowTable table;
  for (int i = 0; i < kReadings; ++i) {
    const int turn = (5 * i) % kReadings;
    Row row{.row = i + 1, .campaign = "place"};
    if (has_times) row.t_s = 60.0 * turn;
    row.cmd_mm = {100, 0, 0};
    row.dir = {1, 0, 0};
    row.n = {1, 0, 0};
    row.value_mm = kStep_mm * turn;
    table.rows.push_back(row);
  }
  return {table, {}, machine, {}};
}

double PureError_mm(const Observed& observed, const std::vector<bool>& left_out) {
  return PureErrorOf(observed, observed.residual_mm(), left_out, 1).sigma_mm[0];
}

// Half the square of each difference, n - 1 of them.
TEST(PureErrorOf, WithTimesADriftIsNoneButForItsSteps) {
  const std::vector<bool> none(kReadings, false);

  EXPECT_NEAR(
      PureError_mm(Creeping(true), none), kStep_mm / std::sqrt(2.0), 1e-6 * kStep_mm);
}

// 0 1 .. n-1 about their mean: n (n + 1) / 12.
TEST(PureErrorOf, WithoutTimesItIsTheScatterAboutTheMean) {
  const std::vector<bool> none(kReadings, false);

  EXPECT_NEAR(PureError_mm(Creeping(false), none),
              kStep_mm * std::sqrt(kReadings * (kReadings + 1) / 12.0),
              1e-6 * kStep_mm);
}

TEST(PureErrorOf, WhatIsLeftOutIsNoReplicate) {
  std::vector<bool> all_but_two(kReadings, true);
  all_but_two[0] = all_but_two[1] = false;  // The first reading and the sixth.

  EXPECT_NEAR(PureError_mm(Creeping(true), all_but_two),
              5 * kStep_mm / std::sqrt(2.0),
              1e-6 * kStep_mm);
}

// A bed on screws stands elsewhere after each homing: that is no noise of a reading.
TEST(PureErrorOf, OfABedOnScrewsTwoHomingsAreNoRepeat) {
  constexpr double kHomedApart_mm = 0.05;
  const Machine machine =
      ReadMachine(CALTWIN_SOURCE_DIR "/models/triple_z_printer/machine.yaml");
  RowTable table;
  for (int i = 0; i < kReadings; ++i) {
    const int home = i / 2;
    Row row{.row = i + 1,
            .campaign = "grid",
            .kind = RowKind::kTouch,
            .setup = "bed",
            .home = std::to_string(home)};
    row.cmd_mm = {100, 100, 0};
    row.dir[2] = -1;
    row.n = {0, 0, 1};
    row.value_mm = home * kHomedApart_mm + (i % 2 == 0 ? 0 : 2 * kStep_mm);
    table.rows.push_back(row);
  }
  const Observed observed(table, {}, machine, {});

  const PureError pure = PureErrorOf(observed, 1);

  EXPECT_EQ(pure.dof[0], kReadings / 2);
  EXPECT_NEAR(pure.sigma_mm[0], std::sqrt(2.0) * kStep_mm, 1e-3 * kStep_mm);
}

}  // namespace
}  // namespace caltwin

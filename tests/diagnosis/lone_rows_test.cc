#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/diagnosis/outliers.h"
#include "sim/machine/machine.h"

namespace caltwin {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// Scatter that is no pattern, in -1 .. 1.
double Scatter(int i) {
  return std::sin(12.9898 * i) * std::cos(78.233 * i);
}

/// Five cycles over six positions, 1 um of scatter about a bent line.
RowTable Cycles() {
  RowTable table;
  for (int i = 0; i < 60; ++i) {
    const int place = i % 12;
    const bool is_forward = place < 6;
    Row row{.row = i + 1, .campaign = "laser", .rep = i / 12 + 1};
    row.cmd_mm = {20.0 + 30 * (is_forward ? place : 11 - place), kUnknown, kUnknown};
    row.n = {1, 0, 0};
    row.dir = {is_forward ? 1.0 : -1.0, 0, 0};
    row.value_mm = 1e-6 * row.cmd_mm[0] * row.cmd_mm[0] + 0.001 * Scatter(i);
    table.rows.push_back(row);
  }
  return table;
}

/// Running numbers of the rows that stand alone.
std::vector<std::int64_t> LoneOf(const RowTable& table) {
  const Observed observed(
      table,
      {},
      ReadMachine(CALTWIN_SOURCE_DIR "/models/gantry_router/machine.yaml"),
      {});
  const std::vector<bool> is_lone = LoneRows(observed);
  std::vector<std::int64_t> rows;
  for (std::size_t i = 0; i < is_lone.size(); ++i) {
    if (is_lone[i]) rows.push_back(table.rows[i].row);
  }
  return rows;
}

TEST(LoneRows, NoneAmongRowsThatRepeat) {
  EXPECT_THAT(LoneOf(Cycles()), IsEmpty());
}

// As in the first cycle of a real axis: no smooth function of time may take them up.
TEST(LoneRows, TheFirstTwoReadings) {
  RowTable table = Cycles();
  table.rows[0].value_mm += 0.1;
  table.rows[1].value_mm += 0.06;
  EXPECT_THAT(LoneOf(table), ElementsAre(1, 2));
}

// A jump reaches many rows: a cause, no outliers.
TEST(LoneRows, WhatReachesManyIsNone) {
  RowTable table = Cycles();
  for (std::size_t i = 0; i < 12; ++i) table.rows[i].value_mm += 0.1;
  EXPECT_THAT(LoneOf(table), IsEmpty());
}

}  // namespace
}  // namespace caltwin

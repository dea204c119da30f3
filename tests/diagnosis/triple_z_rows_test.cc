// Rows of a bed on three screws before, and after, they are diagnosed.
#include <algorithm>
#include <array>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/diagnosis/plausible.h"
#include "calibration/diagnosis/replay.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// Touches whose commanded height follows the screws, or a gauge's readings, move by
// something else than told where motors are swapped: no mistake of the file's.
RowTable AloneSwapped(RowKind kind) {
  RowTable table;
  for (int i = 0; i < 63; ++i) {
    Row row{
        .row = i + 1, .campaign = "screws_one_by_one", .kind = kind, .setup = "bed"};
    const int stage = i / 9;  // Every second with a screw raised.
    const auto screw = static_cast<std::size_t>(stage / 2) % 3;
    const double x = i % 3, y = (i / 3) % 3;
    row.n = {0, 0, 1};
    row.motor_mm = {200, 200, 200};
    const std::array tilt_mm = {5 * (1 - x), 5 * (1 - y), 5 * (x + y - 2)};
    if (stage % 2 == 1) row.motor_mm[screw] += 5;
    const double told_mm = stage % 2 == 1 ? tilt_mm[screw] : 0;
    const double other_mm = stage % 2 == 1 ? tilt_mm[(screw + 1) % 3] : 0;
    row.cmd_mm = {100 * x, 100 * y, 50 + told_mm};
    row.value_mm = (kind == RowKind::kTouch ? -1 : 1) * (other_mm - told_mm) +
                   0.003 * std::sin(12.9898 * i);
    table.rows.push_back(row);
  }
  return table;
}

TEST(TripleZRows, SwappedMotorsAreNoBadInput) {
  const Machine printer =
      ReadMachine(CALTWIN_SOURCE_DIR "/models/triple_z_printer/machine.yaml");
  for (const RowKind kind : {RowKind::kPosition, RowKind::kTouch}) {
    const auto refuses = [&](const RowTable& table) {
      const auto doubts = Doubts(table, {}, &printer);
      return std::ranges::any_of(doubts, &Doubt::refuse);
    };
    RowTable table = AloneSwapped(kind);
    EXPECT_FALSE(refuses(table));
    // The same readings where all screws stood alike are a mistake.
    for (Row& row : table.rows) row.motor_mm = {200, 200, 200};
    EXPECT_TRUE(refuses(table));
  }
}

TEST(TripleZRows, AReplayFarFromTheNoiseSaysSo) {
  Replay replay{.before_mm = 0.2, .after_mm = 0.013, .floor_mm = 0.003, .rows = 100};
  EXPECT_THAT(ReplayText(replay), HasSubstr("4.3 times the noise floor of 3.0 um"));
  replay.after_mm = 0.008;
  EXPECT_THAT(ReplayText(replay), Not(HasSubstr("times the noise floor")));
  replay = {.before_mm = 0.2, .after_mm = 0.0009, .floor_mm = 1e-4, .rows = 100};
  EXPECT_THAT(ReplayText(replay), Not(HasSubstr("times the noise floor")));
}

}  // namespace
}  // namespace caltwin

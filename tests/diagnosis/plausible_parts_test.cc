#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/diagnosis/plausible.h"
#include "sim/base/units.h"
#include "sim/machine/machine.h"

namespace caltwin {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

std::vector<std::string> RefusalsOf(const RowTable& table) {
  std::vector<std::string> kinds;
  for (const Doubt& doubt : Doubts(table, {})) {
    if (doubt.refuse) kinds.push_back(doubt.kind);
  }
  return kinds;
}

// Scatter that is no pattern, in -1 .. 1.
double Scatter(int i) {
  return std::sin(12.9898 * i) * std::cos(78.233 * i);
}

/// Gauge rows along x, 1 um of scatter.
RowTable Gauged(int num) {
  RowTable table;
  for (int i = 0; i < num; ++i) {
    Row row{.row = i + 1, .campaign = "laser"};
    row.n = {1, 0, 0};
    row.dir = {i % 2 == 0 ? 1.0 : -1.0, 0, 0};
    const int place = i / 2;
    row.cmd_mm = {10 + 7.3 * place, 0, 0};
    row.value_mm = 0.001 * Scatter(i);
    table.rows.push_back(row);
  }
  return table;
}

TEST(PlausibleBlocks, RowsInMicrometresAmongOthers) {
  RowTable table = Gauged(60);
  EXPECT_THAT(RefusalsOf(table), IsEmpty());
  for (std::size_t i = 20; i < 31; ++i) {
    table.rows[i].value_mm = 1000 * (table.rows[i].value_mm + 0.004);
  }
  const auto doubts = Doubts(table, {});
  ASSERT_FALSE(doubts.empty());
  EXPECT_EQ(doubts[0].kind, "units_differ");
  EXPECT_TRUE(doubts[0].refuse);
  EXPECT_THAT(doubts[0].message, HasSubstr("of its 60 rows (21 to 31)"));
}

// A machine that lost 5 mm scatters there as it did before.
TEST(PlausibleBlocks, AJumpIsNoUnit) {
  RowTable table = Gauged(60);
  for (std::size_t i = 20; i < 31; ++i) table.rows[i].value_mm += 5;
  EXPECT_THAT(RefusalsOf(table), Not(Contains("units_differ")));
}

// Two campaigns at places of their own along an axis that errs by a slope and a wave;
// the second's positions are written in a unit of `unit_mm`.
RowTable TwoCampaigns(double unit_mm) {
  RowTable table;
  for (int i = 0; i < 80; ++i) {
    const bool is_second = i >= 40;
    const double at_mm = 400 * (0.5 + 0.5 * Scatter(3 * i + 1));
    Row row{.row = i + 1, .campaign = is_second ? "again" : "laser"};
    row.n = {1, 0, 0};
    row.dir = {1, 0, 0};
    row.cmd_mm = {is_second ? at_mm / unit_mm : at_mm, 0, 0};
    row.value_mm = MmFromUm(0.05 * at_mm + 8 * std::sin(at_mm / 60) + Scatter(i));
    table.rows.push_back(row);
  }
  return table;
}

TEST(PlausiblePositions, OneCampaignInAnotherUnitAtPlacesOfItsOwn) {
  const auto hint_of = [](double unit_mm) {
    for (const Doubt& doubt : Doubts(TwoCampaigns(unit_mm), {})) {
      if (doubt.kind == "position_unit" && doubt.refuse) return doubt.hint;
    }
    return std::string();
  };
  EXPECT_THAT(hint_of(25.4), HasSubstr("in inches"));
  EXPECT_THAT(hint_of(10), HasSubstr("in centimetres"));
  EXPECT_THAT(hint_of(1000), HasSubstr("in metres"));
  EXPECT_EQ(hint_of(1), "");
}

TEST(PlausibleCampaigns, AnotherUnitOrSignAtPlacesOfItsOwn) {
  const auto refusals_of = [](double times) {
    RowTable table = TwoCampaigns(1);
    for (Row& row : table.rows) {
      if (row.campaign == "again") row.value_mm *= times;
    }
    return RefusalsOf(table);
  };
  EXPECT_THAT(refusals_of(1), IsEmpty());
  EXPECT_THAT(refusals_of(2.5), IsEmpty());
  EXPECT_THAT(refusals_of(1 / 25.4), Contains("units_differ"));
  EXPECT_THAT(refusals_of(1000 / 25.4), Contains("units_differ"));
  EXPECT_THAT(refusals_of(1000), Contains("units_differ"));
  EXPECT_THAT(refusals_of(-1), Contains("reversed_sign"));
}

// Five runs over the same twelve places of an axis that errs by a slope and loses a gap
// at its reversals.
RowTable FiveRuns() {
  constexpr double kGap_um = 10;
  RowTable table;
  for (int i = 0; i < 120; ++i) {
    const int place = i / 2 % 12;
    const double sense = i % 2 == 0 ? 1 : -1;
    Row row{.row = i + 1, .campaign = "laser", .rep = i / 24 + 1};
    row.n = {1, 0, 0};
    row.dir = {sense, 0, 0};
    row.cmd_mm = {10 + 23.7 * place, 0, 0};
    row.value_mm =
        MmFromUm(0.05 * row.cmd_mm[0] - sense * kGap_um / 2 + 0.5 * Scatter(i));
    table.rows.push_back(row);
  }
  return table;
}

TEST(PlausibleRuns, SomeRunsWrittenDownOtherwise) {
  const auto refusals_of = [](const auto& act) {
    RowTable table = FiveRuns();
    for (Row& row : table.rows) {
      if (row.rep == 2) act(&row);
    }
    return RefusalsOf(table);
  };
  EXPECT_THAT(refusals_of([](Row*) {}), IsEmpty());
  EXPECT_THAT(refusals_of([](Row* row) { row->value_mm *= 1.3; }), IsEmpty());
  EXPECT_THAT(refusals_of([](Row* row) { row->value_mm *= -1; }),
              Contains("reversed_sign"));
  EXPECT_THAT(refusals_of([](Row* row) { row->value_mm /= 25.4; }),
              Contains("units_differ"));
  EXPECT_THAT(refusals_of([](Row* row) { row->dir[0] *= -1; }),
              Contains("reversed_sign"));
}

// A screw that warms from run to run: the slope turns round, and each run is a little
// other than the one before.
TEST(PlausibleRuns, AScrewThatWarmsIsNoReversedSign) {
  RowTable table = FiveRuns();
  for (Row& row : table.rows) {
    const double grown = 0.05 * (static_cast<double>(*row.rep) - 3);
    row.value_mm += MmFromUm((grown - 0.05) * row.cmd_mm[0]);
  }
  EXPECT_THAT(RefusalsOf(table), IsEmpty());
}

// A wave that the coarse campaign cannot follow: between two of its places it goes up,
// where the fine one goes down.
TEST(PlausibleCampaigns, FewCoarsePlacesContradictNothing) {
  RowTable table;
  const auto wave_mm = [](double at_mm) {
    return 0.01 * std::sin(at_mm / 3);
  };
  for (int i = 0; i < 40; ++i) {
    const bool is_fine = i >= 12;
    Row row{.row = i + 1, .campaign = is_fine ? "fine" : "coarse"};
    row.n = {1, 0, 0};
    row.dir = {1, 0, 0};
    row.cmd_mm = {is_fine ? 111 + 0.2 * (i - 12) : 12.7 * i, 0, 0};
    row.value_mm = wave_mm(row.cmd_mm[0]) + MmFromUm(0.2 * Scatter(i));
    table.rows.push_back(row);
  }
  EXPECT_THAT(RefusalsOf(table), IsEmpty());
}

// A campaign over the first centimetres of the axis measures what the other does there.
TEST(PlausiblePositions, AShortCampaignIsInMillimetres) {
  RowTable table = TwoCampaigns(1);
  for (Row& row : table.rows) {
    if (row.campaign != "again") continue;
    row.cmd_mm[0] /= 10;
    row.value_mm = MmFromUm(0.05 * row.cmd_mm[0] + 8 * std::sin(row.cmd_mm[0] / 60) +
                            Scatter(static_cast<int>(row.row)));
  }
  EXPECT_THAT(RefusalsOf(table), IsEmpty());
}

// An edge that lies askew: each touch ends 0.7 mm later than the one before, after a
// retreat of 4 mm.
TEST(PlausibleMoves, TouchesTurnRoundEachTime) {
  RowTable table = Gauged(20);
  for (int i = 0; i < 20; ++i) {
    Row row{.row = 21 + i, .campaign = "edge", .kind = RowKind::kTouch};
    row.cmd_mm = {20.0 + 10 * i, 210, 0};
    row.dir = {0, -1, 0};
    row.n = {0, 1, 0};
    row.since_rev_mm = {kUnknown, 4 + 0.7 * (i % 3), kUnknown};
    row.value_mm = -0.7 * (i % 3) + 0.001 * Scatter(i);
    table.rows.push_back(row);
  }
  EXPECT_THAT(RefusalsOf(table), Not(Contains("moves_contradict")));
}

// A log of a printer of 400 steps/mm, diagnosed with a router of 800.
TEST(PlausibleDrives, AnotherMachinesFileIsTold) {
  const Machine router =
      ReadMachine(CALTWIN_SOURCE_DIR "/models/gantry_router/machine.yaml");
  DataHeader header;
  const auto kinds = [&](double steps_per_mm) {
    header.settings["s1"].steps_per_mm["x"] = steps_per_mm;
    std::vector<std::string> all;
    for (const Doubt& doubt : Doubts(Gauged(60), header, &router)) {
      all.push_back(doubt.kind);
    }
    return all;
  };
  EXPECT_THAT(kinds(808), Not(Contains("other_drive")));
  EXPECT_THAT(kinds(400), Contains("other_drive"));
}

/// A ring (faces inward) and a block (outward), touched by a probe that triggers
/// `late_mm` late on an axis of that scale, the block `size_error_mm` too large.
RowTable Touched(double late_mm, double scale, double size_error_mm) {
  RowTable table = Gauged(40);
  for (Row& row : table.rows) row.value_mm += scale * row.cmd_mm[0];
  for (Row row : Gauged(40).rows) {
    row.campaign = "laser_y";
    row.n = {0, 1, 0};
    row.dir = {0, row.dir[0], 0};
    row.cmd_mm = {0, row.cmd_mm[0], 0};
    row.value_mm += scale * row.cmd_mm[1];
    table.rows.push_back(row);
  }
  for (int i = 0; i < 48; ++i) {
    const bool is_ring = i < 24;
    const double angle = 2 * std::numbers::pi * i / 24;
    const double turn = is_ring ? angle : std::numbers::pi / 2 * (i % 4);
    const double out = is_ring ? -1 : 1, radius_mm = is_ring ? 25 : 38.1;
    Row row{.campaign = is_ring ? "ring" : "block", .kind = RowKind::kTouch};
    row.n = {out * std::cos(turn), out * std::sin(turn), 0};
    row.cmd_mm = {
        150 + radius_mm * std::cos(turn), 150 + radius_mm * std::sin(turn), 0};
    row.feature = is_ring ? "ring.bore" : "block.side";
    const double along_mm = row.cmd_mm[0] * row.n[0] + row.cmd_mm[1] * row.n[1];
    row.value_mm = -late_mm - scale * along_mm + (is_ring ? 0 : size_error_mm / 2) +
                   0.001 * Scatter(i);
    table.rows.push_back(row);
  }
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    table.rows[i].row = static_cast<std::int64_t>(i + 1);
  }
  return table;
}

TEST(PlausibleFaces, OneCampaignOfTouchesReversed) {
  for (const double scale : {0.0, 0.002, -0.002}) {
    RowTable table = Touched(/*late_mm=*/0.02, scale, /*size_error_mm=*/0);
    EXPECT_THAT(RefusalsOf(table), IsEmpty()) << scale;
    for (Row& row : table.rows) {
      if (row.campaign == "ring") row.value_mm *= -1;
    }
    EXPECT_THAT(RefusalsOf(table), ElementsAre("reversed_sign"));
  }
}

TEST(PlausibleFaces, AWrongBlockIsNoReversedSign) {
  EXPECT_THAT(RefusalsOf(Touched(0.02, 0, /*size_error_mm=*/0.03)), IsEmpty());
  EXPECT_THAT(RefusalsOf(Touched(0.02, 0, /*size_error_mm=*/-0.03)), IsEmpty());
}

// Out of the material no probe can come.
TEST(PlausibleFaces, TouchesComeUponTheirFace) {
  const auto refusals = [](double sense) {
    RowTable table = Touched(0.02, 0, 0);
    for (Row& row : table.rows) {
      if (row.campaign == "block") {
        row.dir = {sense * row.n[0], sense * row.n[1], 0};
      }
    }
    return RefusalsOf(table);
  };
  EXPECT_THAT(refusals(-1), IsEmpty());
  EXPECT_THAT(refusals(1), ElementsAre("reversed_sign"));
}

// Faces touched off their middle read its turn; no other sign makes up for that.
TEST(PlausibleFaces, ATurnedBlockIsNoReversedSign) {
  constexpr double kTurn_rad = 0.004, kOff_mm = 20;
  RowTable table = Touched(0.02, 0, 0);
  for (Row& row : table.rows) {
    if (row.campaign != "block") continue;
    row.cmd_mm[0] += kOff_mm * row.n[1];
    row.value_mm += kTurn_rad * ((row.cmd_mm[0] - 150) * row.n[1] -
                                 (row.cmd_mm[1] - 150) * row.n[0]);
  }
  EXPECT_THAT(RefusalsOf(table), IsEmpty());
}

/// A plate touched 7 x 7 by "plate" and again by "again", turned by `turn_deg`; the
/// second reads `times` the twist that the first read.
RowTable PlateTouchedTwice(double turn_deg, double times, double lean_um_per_mm) {
  RowTable table;
  for (int i = 0; i < 98; ++i) {
    const bool is_second = i >= 49;
    const double x_mm = 40 * (i % 7 - 3), y_mm = 40 * (i / 7 % 7 - 3);
    Row row{.row = i + 1, .campaign = is_second ? "again" : "plate"};
    row.kind = RowKind::kTouch;
    row.n = {0, 0, 1};
    row.cmd_mm = {150 + x_mm, 150 + y_mm, 0};
    row.artefact_turn_deg = is_second ? turn_deg : 0;
    const double twist_mm = 1e-6 * x_mm * y_mm;
    const double lean_mm = MmFromUm(lean_um_per_mm) * x_mm;
    row.value_mm = (is_second ? times : 1) * twist_mm + (is_second ? -1 : 1) * lean_mm +
                   0.001 * Scatter(i);
    table.rows.push_back(row);
  }
  return table;
}

// xy of a plate turned by a quarter is -xy: a twisted bed under it stays as it is.
TEST(PlausibleCampaigns, APlateTurnedReadsTheOppositeByRight) {
  EXPECT_THAT(RefusalsOf(PlateTouchedTwice(90, -1, 0)), IsEmpty());
  EXPECT_THAT(RefusalsOf(PlateTouchedTwice(0, -1, 0)), ElementsAre("reversed_sign"));
}

// How a plate leans is how it was laid; what is left of it is judged.
TEST(PlausibleCampaigns, APlateLaidLeaningIsNoReversedSign) {
  EXPECT_THAT(RefusalsOf(PlateTouchedTwice(0, 1, 0.5)), IsEmpty());
  EXPECT_THAT(RefusalsOf(PlateTouchedTwice(0, -1, 0.5)), ElementsAre("reversed_sign"));
}

// Below and above the temperature at which it is true, a screw is short and long.
TEST(PlausibleCampaigns, AColdScrewAndAWarmOneAreOpposite) {
  RowTable table = Gauged(40);
  for (Row row : Gauged(40).rows) {
    row.campaign = "warm";
    table.rows.push_back(row);
  }
  const auto refusals = [&](double cold_c, double warm_c) {
    for (std::size_t i = 0; i < table.rows.size(); ++i) {
      const bool is_warm = i >= 40;
      table.rows[i].row = static_cast<std::int64_t>(i + 1);
      table.rows[i].temp_screw_c = is_warm ? warm_c : cold_c;
      table.rows[i].value_mm = (is_warm ? 6e-5 : -6e-5) * table.rows[i].cmd_mm[0];
    }
    return RefusalsOf(table);
  };
  EXPECT_THAT(refusals(15, 25), IsEmpty());
  EXPECT_THAT(refusals(20, 20), ElementsAre("reversed_sign"));
}

}  // namespace
}  // namespace caltwin

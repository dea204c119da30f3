#include "calibration/diagnosis/plausible.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/units.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/kinds.h"
#include "sim/measure/rows.h"
#include "tests/diagnosis/doubted.h"

namespace caltwin {
namespace {

using ::testing::Contains;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

/// The rows of X twice, the second time as another campaign, changed.
RowTable WithSecondCampaign(const std::function<void(Row*)>& act) {
  RowTable table = X();
  for (Row row : X().rows) {
    row.campaign = "again";
    row.row += 90;
    act(&row);
    table.rows.push_back(row);
  }
  return table;
}

TEST(Plausible, RealAxesAreNotDoubted) {
  for (const char* name :
       {"ess_target_x_2022-04", "ess_target_y_2022-04", "psi_mcu1025_2021-11-10"}) {
    EXPECT_THAT(KindsOf(RealAxis(name)), IsEmpty()) << name;
  }
}

TEST(Plausible, WhatIsNoNumberIsRefused) {
  for (const double bad : {kUnknown, HUGE_VAL}) {
    RowTable table = X();
    table.rows[6].value_mm = bad;
    const std::vector<Doubt> doubts = Doubts(table, {});

    ASSERT_THAT(doubts, SizeIs(1));
    EXPECT_EQ(doubts[0].kind, "not_finite");
    EXPECT_THAT(doubts[0].rows, ElementsAre(7));
    EXPECT_TRUE(doubts[0].refuse);
  }
}

TEST(Plausible, TwoRowsAreTooFewForACause) {
  RowTable table = X();
  table.rows.resize(2);
  EXPECT_THAT(KindsOf(table), ElementsAre("too_few"));
  EXPECT_THAT(KindsOf({}), ElementsAre("too_few"));
}

TEST(Plausible, ReadingsInMicrometresAreRefused) {
  EXPECT_THAT(KindsAfter([](Row* row) { row->value_mm = UmFromMm(row->value_mm); }),
              Contains("value_unit!"));
}

TEST(Plausible, PositionsInInchesAreRefused) {
  EXPECT_THAT(KindsAfter([](Row* row) { row->cmd_mm[0] /= MmFromInch(1.0); }),
              Contains("position_unit!"));
  // Rounded as people write them.
  EXPECT_THAT(KindsAfter([](Row* row) {
                row->cmd_mm[0] = std::round(row->cmd_mm[0] / 25.4 * 1e4) / 1e4;
              }),
              Contains("position_unit!"));
}

TEST(Plausible, OneCampaignInInchesIsRefused) {
  RowTable table = X();
  for (Row row : X().rows) {
    row.row += 1000;
    row.campaign = "in_inches";
    row.cmd_mm[0] /= MmFromInch(1.0);
    table.rows.push_back(row);
  }
  EXPECT_THAT(KindsOf(table), Contains("position_unit!"));
}

TEST(Plausible, TheGaugeInInchesTheCommandInMillimetres) {
  const auto actual_in_inches = [](Row* row) {
    const double actual_mm = row->cmd_mm[0] + row->value_mm;
    row->value_mm = actual_mm / MmFromInch(1.0) - row->cmd_mm[0];
  };
  EXPECT_THAT(KindsAfter(actual_in_inches), Contains("position_unit!"));
}

TEST(Plausible, APositionInPlaceOfADeviationIsRefused) {
  EXPECT_THAT(KindsAfter([](Row* row) { row->value_mm += row->cmd_mm[0]; }),
              Contains("value_is_position!"));
  EXPECT_THAT(KindsAfter([](Row* row) { row->value_mm -= row->cmd_mm[0]; }),
              Contains("value_is_position!"));
  EXPECT_THAT(KindsAfter([](Row* row) { row->value_mm -= 2 * row->cmd_mm[0]; }),
              Contains("reversed_axis!"));
}

// A machine may be that wrong; its rows are not to be refused.
TEST(Plausible, AScaleWrongByAFifthIsAFinding) {
  EXPECT_THAT(KindsAfter([](Row* row) { row->value_mm += 0.2 * row->cmd_mm[0]; }),
              IsEmpty());
}

TEST(Plausible, CopiesOfRowsAreToldAndTheLaterOnesNamed) {
  RowTable table = X();
  for (int i = 0; i < 3; ++i) {
    table.rows.push_back(table.rows[10 + i]);
    table.rows.back().row = 91 + i;
  }
  const std::vector<Doubt> doubts = Doubts(table, {});

  ASSERT_THAT(doubts, SizeIs(1));
  EXPECT_EQ(doubts[0].kind, "duplicated_rows");
  EXPECT_THAT(doubts[0].rows, ElementsAre(91, 92, 93));
}

TEST(Plausible, AFilePastedTwiceIsToldWithoutRepetitionsToo) {
  RowTable table = X();
  for (Row& row : table.rows) row.rep.reset();
  EXPECT_THAT(KindsOf(table), IsEmpty());  // A few equal readings are no copies.
  const std::vector<Row> rows = table.rows;
  for (const Row& row : rows) {
    table.rows.push_back(row);
    table.rows.back().row += 90;
  }
  const std::vector<Doubt> doubts = Doubts(table, {});

  ASSERT_THAT(doubts, SizeIs(1));
  EXPECT_THAT(doubts[0].rows, SizeIs(90));
  EXPECT_EQ(doubts[0].rows.front(), 91);
}

TEST(Plausible, TimeThatRunsBackwardsIsTold) {
  EXPECT_THAT(KindsAfter([](Row* row) { row->t_s = static_cast<double>(row->row); }),
              IsEmpty());
  RowTable table = X();
  for (Row& row : table.rows) row.t_s = static_cast<double>(row.row % 50);
  const std::vector<Doubt> doubts = Doubts(table, {});
  ASSERT_THAT(doubts, SizeIs(1));
  EXPECT_EQ(doubts[0].kind, "time_backwards");
  EXPECT_THAT(doubts[0].rows, ElementsAre(50));
}

TEST(Plausible, FileOrderIsNotTimeWhereRowsAreNumbered) {
  RowTable table = X();
  for (Row& row : table.rows) row.t_s = static_cast<double>(row.row);
  std::ranges::reverse(table.rows);
  EXPECT_THAT(KindsOf(table), IsEmpty());
}

TEST(Plausible, OneSenseAndNoSenseAreTold) {
  RowTable forward = X();
  std::erase_if(forward.rows, [](const Row& row) { return row.dir[0] < 0; });
  EXPECT_THAT(KindsOf(forward), ElementsAre("one_direction"));
  EXPECT_THAT(KindsAfter([](Row* row) { row->dir[0] = kUnknown; }),
              ElementsAre("direction_unknown"));
}

TEST(Plausible, ASenseWrittenNoughtIsRefused) {
  EXPECT_THAT(KindsAfter([](Row* row) { row->dir[0] = row->dir[0] > 0 ? 1 : 0; }),
              Contains("sense_of_nought!"));
  // Another axis moved last, and this one stood.
  EXPECT_THAT(KindsAfter([](Row* row) {
                row->dir = row->dir[0] > 0 ? std::array<double, 3>{1, 0, 0}
                                           : std::array<double, 3>{0, 1, 0};
              }),
              Not(Contains("sense_of_nought!")));
}

TEST(Plausible, CampaignsThatContradictEachOther) {
  EXPECT_THAT(KindsOf(WithSecondCampaign([](Row* row) { row->value_mm *= 1.1; })),
              IsEmpty());
  EXPECT_THAT(KindsOf(WithSecondCampaign([](Row* row) { row->value_mm *= -1; })),
              Contains("reversed_sign!"));
  EXPECT_THAT(KindsOf(WithSecondCampaign([](Row* row) { row->value_mm /= 25.4; })),
              ElementsAre("units_differ!"));
  EXPECT_THAT(
      KindsOf(WithSecondCampaign([](Row* row) { row->value_mm *= UmFromMm(1.0); })),
      Contains("units_differ!"));
}

// Settings changed between the two: the machine itself may have been turned about.
TEST(Plausible, OtherSettingsMayReverseTheReadings) {
  const RowTable table = WithSecondCampaign([](Row* row) {
    row->value_mm *= -1;
    row->settings = "s2";
  });
  EXPECT_THAT(KindsOf(table), Not(Contains("reversed_sign!")));
}

TEST(Plausible, AGapThatLeadsIsTold) {
  EXPECT_THAT(KindsAfter([](Row* row) { row->value_mm += 0.06 * row->dir[0]; }),
              ElementsAre("negative_gap"));
}

// Two campaigns along x at other places, both senses; `turn` changes those of the
// second.
std::vector<std::string> KindsOfTwo(double half_gap_mm,
                                    const std::function<void(Row*)>& turn) {
  RowTable table;
  for (int i = 0; i < 64; ++i) {
    const bool is_second = i >= 32;
    const double sense = i % 2 == 0 ? 1 : -1;
    Row row{.row = i + 1, .campaign = is_second ? "second" : "first"};
    row.n = {1, 0, 0};
    row.dir = {sense, 0, 0};
    row.cmd_mm = {10 + 17.3 * (i / 2 % 16) + (is_second ? 3.1 : 0), 0, 0};
    row.value_mm = 0.001 * ((i * 7) % 5) - half_gap_mm * sense;
    if (is_second) turn(&row);
    table.rows.push_back(row);
  }
  return KindsOf(table);
}

TEST(Plausible, OneAxisHasOneGap) {
  const auto kinds = [](double times) {
    return KindsOfTwo(0.02, [&](Row* row) { row->value_mm *= times; });
  };
  EXPECT_THAT(kinds(1), Not(Contains("units_differ!")));
  EXPECT_THAT(kinds(3), Not(Contains("units_differ!")));
  EXPECT_THAT(kinds(1 / 25.4), Contains("units_differ!"));
  EXPECT_THAT(kinds(25.4), Contains("units_differ!"));
}

TEST(Plausible, OneGapCannotLagAndLead) {
  const auto kinds = [](double value_sign, double sense_sign, const char* settings) {
    return KindsOfTwo(0.005, [&](Row* row) {
      row->value_mm *= value_sign;
      row->dir[0] *= sense_sign;
      row->settings = settings;
    });
  };
  EXPECT_THAT(kinds(1, 1, ""), Not(Contains("reversed_sign!")));
  EXPECT_THAT(kinds(-1, 1, ""), Contains("reversed_sign!"));
  EXPECT_THAT(kinds(1, -1, ""), Contains("reversed_sign!"));
  EXPECT_THAT(kinds(1, -1, "overcompensated"), Not(Contains("reversed_sign!")));
}

/// A pass along x and y that says what it travelled.
RowTable Passes() {
  RowTable table;
  for (int i = 0; i < 24; ++i) {
    const int axis = i / 12;
    Row row{.row = i + 1, .campaign = "pass"};
    row.n = {0, 0, 0};
    row.n[static_cast<std::size_t>(axis)] = 1;
    row.cmd_mm = {100, 50, 10};
    row.cmd_mm[static_cast<std::size_t>(axis)] = 20 + 7.3 * (i % 12);
    row.dir = {0, 0, 0};
    row.dir[static_cast<std::size_t>(axis)] = 1;
    row.since_rev_mm[static_cast<std::size_t>(axis)] = 5 + 7.3 * (i % 12);
    row.value_mm = 0.001 * (i % 5);
    table.rows.push_back(row);
  }
  return table;
}

// Five places at equal steps of 50.0788 mm are round numbers as inches, by chance: they
// would span five metres.
TEST(Plausible, AGridOfEqualStepsIsNotInInches) {
  RowTable table = Passes();
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    table.rows[i].cmd_mm[0] = 15 + 50.0788 * static_cast<double>(i % 5);
    table.rows[i].since_rev_mm = {kUnknown, kUnknown, kUnknown};
  }

  EXPECT_THAT(KindsOf(table), Not(Contains("position_unit!")));
}

// Six places at equal steps of 20.315 mm, too: no printer of this size goes to 1290 mm.
// The same on one that large is refused.
TEST(Plausible, WhereTheMachineCannotGoNothingIsInInches) {
  RowTable table = Passes();
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    table.rows[i].cmd_mm[0] = 10.1575 * (2 * static_cast<double>(i % 6) - 5);
    table.rows[i].since_rev_mm = {kUnknown, kUnknown, kUnknown};
  }
  Machine small;
  for (AxisDrawing& axis : small.axes) axis.min_mm = -300, axis.max_mm = 300;
  Machine large = small;
  large.axes[0] = {.min_mm = -1400, .max_mm = 1400};
  Machine delta = small;
  delta.kind = DeltaKind();
  delta.own = DeltaDrawing{};

  EXPECT_THAT(KindsOf(table, {}, &small), Not(Contains("position_unit!")));
  EXPECT_THAT(KindsOf(table, {}, &delta), Not(Contains("position_unit!")));
  EXPECT_THAT(KindsOf(table, {}, &large), Contains("position_unit!"));
}

TEST(Plausible, TravelsMustBeThoseOfTheCommands) {
  EXPECT_THAT(KindsOf(Passes()), Each(Not(HasSubstr("!"))));

  RowTable inches = Passes();
  for (Row& row : inches.rows) row.cmd_mm[1] /= 25.4;
  EXPECT_THAT(KindsOf(inches), Contains("position_unit!"));

  RowTable swapped = Passes();
  for (Row& row : swapped.rows) std::swap(row.cmd_mm[0], row.cmd_mm[1]);
  EXPECT_THAT(KindsOf(swapped), Contains("moves_contradict!"));

  // A retract between readings is no contradiction: the travel begins anew.
  RowTable retracting = Passes();
  for (Row& row : retracting.rows) row.since_rev_mm = {4, 4, 4};
  EXPECT_THAT(KindsOf(retracting), Each(Not(HasSubstr("!"))));
}

TEST(Plausible, AStuckGaugeIsRefused) {
  EXPECT_THAT(KindsAfter([](Row* row) { row->value_mm = 0.004; }),
              Contains("constant!"));
}

TEST(Plausible, CoarseStepsAreTold) {
  EXPECT_THAT(KindsAfter([](Row* row) {
                row->value_mm = 0.02 * std::round(row->value_mm / 0.02);
              }),
              ElementsAre("quantised"));
}

TEST(Plausible, PositionsBeyondTheTravelAreRefused) {
  Machine machine;
  machine.axes[0].min_mm = 0;
  machine.axes[0].max_mm = 300;
  const std::vector<Doubt> doubts = Doubts(X(), {}, &machine);

  ASSERT_THAT(doubts, SizeIs(1));
  EXPECT_EQ(doubts[0].kind, "outside_travel");
  EXPECT_THAT(doubts[0].rows, SizeIs(10));  // -20 mm, five runs, both senses.
  EXPECT_THAT(doubts[0].message, HasSubstr("beyond the travel of x (0 .. 300 mm)"));
}

// Sizes of effects that machines do have must pass: noise is no doubt.
TEST(Plausible, LargeErrorsOfARealMachineAreNotRefused) {
  for (const double times : {1.0, 3.0, 10.0}) {
    const auto kinds = KindsAfter([&](Row* row) { row->value_mm *= times; });
    EXPECT_THAT(kinds, Each(Not(HasSubstr("!")))) << times;
  }
}

}  // namespace
}  // namespace caltwin

#include "calibration/estimate/iso230.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/rng.h"
#include "sim/base/units.h"
#include "sim/measure/rows.h"

namespace caltwin {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// One position and direction: three readings mean - d, mean, mean + d, whose standard
/// deviation is d.
struct Triple {
  double target_mm = 0;
  double dir = 1;
  double mean_um = 0;
  double d_um = 0;
};

const std::vector<Triple> kByHand = {
    {0, +1, 1, 1},
    {10, +1, 5, 1},
    {25, +1, -2, 3},  //
    {25, -1, -1, 0},
    {10, -1, 3, 1},
    {0, -1, 4, 2},
};

Row ReadingOf(const Triple& triple, double k, double n = 1) {
  Row row{.campaign = "c", .value_mm = n * MmFromUm(triple.mean_um + k * triple.d_um)};
  row.cmd_mm[0] = triple.target_mm;
  row.dir[0] = triple.dir;
  row.n = {n, 0, 0};
  return row;
}

RowTable TableOf(const std::vector<Triple>& triples, double n = 1) {
  RowTable table;
  for (const Triple& triple : triples) {
    for (const double k : {-1, 0, 1}) table.rows.push_back(ReadingOf(triple, k, n));
  }
  return table;
}

Iso230Sheet SheetOf(const std::vector<Triple>& triples,
                    const Iso230Budget& budget = {}) {
  return EvaluateIso230(TableOf(triples), {Axis::kX, "c"}, budget);
}

void ExpectUm(const std::optional<double>& value_mm, double expected_um) {
  ASSERT_TRUE(value_mm.has_value());
  EXPECT_NEAR(UmFromMm(*value_mm), expected_um, 1e-9);
}

// Worked by hand from STANDARDS, so it fails where the public script's R = max(R^, Rv)
// or its E = E^ is used.
TEST(Iso230, EverySymbolAsWorkedByHand) {
  const Iso230Symbols s = SheetOf(kByHand).symbols;

  ExpectUm(s.a_fwd, 7 - -8);  // 5 + 2 1 at 10 mm, -2 - 2 3 at 25 mm.
  ExpectUm(s.a_bwd, 8 - -1);  // 4 + 2 2 at 0 mm, -1 - 2 0 at 25 mm.
  ExpectUm(s.a, 8 - -8);      // Over both directions.
  ExpectUm(s.e_fwd, 5 - -2);
  ExpectUm(s.e_bwd, 4 - -1);
  ExpectUm(s.e, 5 - -2);
  ExpectUm(s.m, 4 - -1.5);  // Means 2.5, 4, -1.5.
  ExpectUm(s.b, 3);         // -3, 2, -1.
  ExpectUm(s.b_mean, -2.0 / 3);
  ExpectUm(s.r_fwd, 4 * 3);
  ExpectUm(s.r_bwd, 4 * 2);
  ExpectUm(s.r, 12);  // 9, 6 and, by scatter, 12.
}

TEST(Iso230, RepeatabilityHoldsTheReversal) {
  std::vector<Triple> triples = kByHand;
  triples[0].mean_um = -9;  // B = -13 at 0 mm: R = 2 1 + 2 2 + 13.

  ExpectUm(SheetOf(triples).symbols.r, 19);
}

TEST(Iso230, PositionsAreListedInOrder) {
  const Iso230Sheet sheet = SheetOf(kByHand);

  ASSERT_THAT(sheet.positions, SizeIs(3));
  EXPECT_EQ(sheet.positions[1].target_mm, 10);
  EXPECT_EQ(sheet.positions[1].runs_fwd, 3);
  ExpectUm(sheet.positions[1].mean_fwd_mm, 5);
  ExpectUm(sheet.positions[1].mean_bwd_mm, 3);
  ExpectUm(sheet.positions[1].s_fwd_mm, 1);
  ExpectUm(sheet.positions[1].b_mm, 2);
  EXPECT_EQ(sheet.runs_min, 3);
}

TEST(Iso230, AReadingAlongTheNegativeEndIsTurned) {
  const Iso230Sheet sheet = EvaluateIso230(TableOf(kByHand, -1), {Axis::kX, "c"}, {});

  ExpectUm(sheet.symbols.a, 16);
  ExpectUm(sheet.symbols.b_mean, -2.0 / 3);
}

TEST(Iso230, ASecondDirectionThatIsMissingLeavesItsSymbolsEmpty) {
  const std::vector<Triple> forward(kByHand.begin(), kByHand.begin() + 3);
  const Iso230Sheet sheet = SheetOf(forward);
  const Iso230Symbols& s = sheet.symbols;

  ExpectUm(s.a_fwd, 15);
  ExpectUm(s.r_fwd, 12);
  ExpectUm(s.e_fwd, 7);
  for (const auto& none :
       {s.a, s.r, s.e, s.m, s.b, s.b_mean, s.a_bwd, s.r_bwd, s.e_bwd}) {
    EXPECT_FALSE(none.has_value());
  }
  EXPECT_THAT(sheet.remarks,
              Contains("3 of 3 positions were not reached from both directions: what "
                       "needs both is not stated"));
}

TEST(Iso230, ReadingsWithoutADirectionAreLeftOutAndCounted) {
  RowTable table = TableOf(kByHand);
  table.rows[0].dir[0] = kUnknown;
  table.rows[3].dir[0] = 0;
  const Iso230Sheet sheet = EvaluateIso230(table, {Axis::kX, "c"});

  EXPECT_EQ(sheet.rows_without_direction, 2);
  EXPECT_THAT(sheet.remarks, Contains("2 readings have no direction and are left out"));
  EXPECT_EQ(sheet.positions[0].runs_fwd, 2);

  for (Row& row : table.rows) row.dir[0] = kUnknown;
  const Iso230Symbols none = EvaluateIso230(table, {Axis::kX, "c"}).symbols;
  for (const NamedSymbol& symbol : AllIso230Symbols()) {
    EXPECT_FALSE((none.*symbol.value).has_value()) << symbol.name;
  }
}

TEST(Iso230, ASingleRunHasNoScatterButAReversal) {
  RowTable table;
  for (const Triple& triple : kByHand) table.rows.push_back(ReadingOf(triple, 0));
  const Iso230Sheet sheet =
      EvaluateIso230(table, {Axis::kX, "c"}, {.is_known = true, .reading_u_um = 1});
  const Iso230Symbols& s = sheet.symbols;

  for (const auto& none : {s.a, s.r, s.a_fwd, s.r_fwd}) EXPECT_FALSE(none.has_value());
  ExpectUm(s.e, 7);
  ExpectUm(s.b, 3);
  ExpectUm(sheet.expanded_u.b, 2 * std::sqrt(2.0));
  EXPECT_FALSE(sheet.expanded_u.r.has_value());
}

TEST(Iso230, TargetsCloserThanATenthOfAMicrometreAreOne) {
  std::vector<Triple> triples = kByHand;
  triples[3].target_mm += 0.00005;
  EXPECT_THAT(SheetOf(triples).positions, SizeIs(3));
  triples[3].target_mm += 0.001;
  EXPECT_THAT(SheetOf(triples).positions, SizeIs(4));
}

TEST(Iso230, EvenSpacingAndFewRunsAreRemarkedUpon) {
  std::vector<Triple> triples = kByHand;
  for (Triple& triple : triples) {
    if (triple.target_mm == 25) triple.target_mm = 20;
  }
  EXPECT_THAT(SheetOf(triples).remarks, Contains(HasSubstr("evenly spaced")));
  EXPECT_THAT(SheetOf(kByHand).remarks, Not(Contains(HasSubstr("evenly spaced"))));
  EXPECT_THAT(SheetOf(kByHand).remarks,
              Contains("ISO 230-2 asks for 5 runs in each direction, here are 3"));
}

TEST(Iso230, WithoutABudgetNoUncertaintyIsStated) {
  const Iso230Sheet sheet = SheetOf(kByHand);
  for (const NamedSymbol& symbol : AllIso230Symbols()) {
    EXPECT_FALSE((sheet.expanded_u.*symbol.value).has_value()) << symbol.name;
  }
}

TEST(Iso230, AnErrorOverTheTravelDoesNotTouchReversalAndRepeatability) {
  const Iso230Symbols u = SheetOf(kByHand,
                                  {.is_known = true,
                                   .device_u_um = 1.2,
                                   .alignment_u_um = 0.3,
                                   .temperature_u_um = 0.4})
                              .expanded_u;
  const double u_travel_um = 1.3;  // sqrt(1.44 + 0.09 + 0.16)

  for (const auto& of_travel : {u.a, u.e, u.m, u.a_fwd, u.a_bwd, u.e_fwd, u.e_bwd}) {
    ExpectUm(of_travel, 2 * u_travel_um);
  }
  for (const auto& at_a_place : {u.b, u.b_mean, u.r, u.r_fwd, u.r_bwd}) {
    ExpectUm(at_a_place, 0);
  }
}

// U is twice the standard deviation that noise of the readings gives each symbol, for
// extremes far enough apart to stay where they are.
TEST(Iso230, UncertaintyIsTheScatterOverRepeats) {
  constexpr int kRepeats = 2000;
  constexpr double kNoise_um = 0.01;
  std::vector<Triple> triples = kByHand;
  triples[3].d_um = 1;
  for (const double first_um : {1.0, -30.0}) {  // R by scatter; R by the reversal.
    triples[0].mean_um = first_um;
    const RowTable table = TableOf(triples);
    Rng rng(1, 0, "iso230");
    std::vector<double> sum(AllIso230Symbols().size()), squares(sum.size());
    const Iso230Sheet exact = EvaluateIso230(
        table, {Axis::kX, "c"}, {.is_known = true, .reading_u_um = kNoise_um});
    for (int repeat = 0; repeat < kRepeats; ++repeat) {
      RowTable noisy = table;
      for (Row& row : noisy.rows) row.value_mm += MmFromUm(kNoise_um) * rng.Normal();
      const Iso230Symbols found = EvaluateIso230(noisy, {Axis::kX, "c"}).symbols;
      for (std::size_t i = 0; i < sum.size(); ++i) {
        const auto member = AllIso230Symbols()[i].value;
        const double off = *(found.*member) - *(exact.symbols.*member);
        sum[i] += off / kRepeats;
        squares[i] += off * off / kRepeats;
      }
    }
    for (std::size_t i = 0; i < sum.size(); ++i) {
      const NamedSymbol& symbol = AllIso230Symbols()[i];
      const double u_mm = *(exact.expanded_u.*symbol.value) / 2;
      const double sd_mm = std::sqrt(squares[i] - sum[i] * sum[i]);
      // Four standard deviations of a standard deviation.
      EXPECT_NEAR(sd_mm / u_mm, 1, 4 / std::sqrt(2.0 * kRepeats)) << symbol.name;
    }
  }
}

TEST(Iso230Choices, AreAxesMeasuredAlongTheirOwnMotion) {
  RowTable table = TableOf(kByHand);
  Row across{.campaign = "straightness", .value_mm = 0};
  across.n = {0, 1, 0};
  for (const double x_mm : {0.0, 10.0}) {
    across.cmd_mm = {x_mm, 5, kUnknown};
    table.rows.push_back(across);
  }
  Row touch{.campaign = "touch", .kind = RowKind::kTouch, .value_mm = 0};
  touch.n = {1, 0, 0};
  for (const double x_mm : {0.0, 10.0}) {
    touch.cmd_mm[0] = x_mm;
    table.rows.push_back(touch);
  }
  Row second = touch;
  second.kind = RowKind::kPosition;
  second.campaign = "second";
  for (const double x_mm : {0.0, 10.0}) {
    second.cmd_mm[0] = x_mm;
    table.rows.push_back(second);
  }
  const auto choices = Iso230Choices(table);

  ASSERT_THAT(choices, SizeIs(2));
  EXPECT_EQ(choices[0].campaign, "c");
  EXPECT_EQ(choices[1].campaign, "second");
  EXPECT_THAT(Iso230Choices({}), IsEmpty());
}

/// A real axis, and what an independent evaluation of the formulas (Python's statistics
/// module) gives [um].
struct RealAxis {
  const char* file;
  std::vector<double> expected_um;  ///< A R E M B B_mean, then A R E of each direction.
};

TEST(Iso230, RealAxesAsEvaluatedIndependently) {
  const std::vector<RealAxis> axes = {
      {"ess_target_x_2022-04",
       {135.2713,
        55.1611,
        122.8474,
        93.6527,
        33.5760,
        -25.3685,
        111.4979,
        108.4212,
        19.3654,
        28.3109,
        98.0340,
        90.6452}},
      {"ess_target_y_2022-04",
       {125.7164,
        46.8655,
        100.0530,
        84.2648,
        20.0200,
        -12.7680,
        104.0005,
        111.3950,
        38.0741,
        32.5442,
        80.0330,
        88.4966}},
      {"psi_mcu1025_2021-11-10",
       {230.3648,
        230.3648,
        70.0876,
        35.9982,
        46.4856,
        -8.2940,
        230.3648,
        58.5322,
        230.3648,
        7.5098,
        57.2658,
        54.0548}},
  };
  for (const RealAxis& axis : axes) {
    const RowTable table = ReadRows(std::string(CALTWIN_SOURCE_DIR) +
                                    "/tests/data/iso230/" + axis.file + ".csv");
    const auto choices = Iso230Choices(table);
    ASSERT_THAT(choices, SizeIs(1)) << axis.file;
    const Iso230Sheet sheet = EvaluateIso230(table, choices[0]);

    EXPECT_EQ(sheet.runs_min, 5);
    EXPECT_EQ(sheet.runs_max, 5);
    for (std::size_t i = 0; i < axis.expected_um.size(); ++i) {
      const NamedSymbol& symbol = AllIso230Symbols()[i];
      ASSERT_TRUE((sheet.symbols.*symbol.value).has_value());
      EXPECT_NEAR(UmFromMm(*(sheet.symbols.*symbol.value)), axis.expected_um[i], 5e-5)
          << axis.file << " " << symbol.name;  // Half a unit of the last digit stated.
    }
  }
}

}  // namespace
}  // namespace caltwin

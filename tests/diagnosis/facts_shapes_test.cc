// An axis that is right but for a stretch, maps that differ by a plane, a delta's seven
// heights, fine ratios: against closed forms.

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/facts/ratios.h"
#include "sim/base/rng.h"
#include "tests/diagnosis/facts_of.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;

// Marks every 20 mm, twice, 1 um apart.
std::vector<Row> Marks(double (*off_mm)(double)) {
  std::vector<Row> rows;
  for (const double scatter_mm : {-0.0005, 0.0005}) {
    for (int i = 0; i <= 10; ++i) {
      Row row{.campaign = "marks"};
      row.cmd_mm = {20.0 * i, kUnknown, kUnknown};
      row.n = {1, 0, 0};
      row.value_mm = off_mm(20.0 * i) + (i % 2 == 0 ? scatter_mm : -scatter_mm);
      rows.push_back(row);
    }
  }
  return rows;
}

TEST(Stretch, IsToldWithItsEndsAndNoScaleIs) {
  const Facts facts = FactsOfRows(
      Marks([](double x_mm) { return 0.05 * std::clamp(x_mm - 80, 0.0, 80.0); }));
  const Fact* fact = facts.Find("stretch");
  ASSERT_NE(fact, nullptr);
  EXPECT_EQ(fact->axis, "x");
  EXPECT_EQ(FigureOf(*fact, "from_mm"), 80);
  EXPECT_EQ(FigureOf(*fact, "to_mm"), 160);
  EXPECT_NEAR(FigureOf(*fact, "factor"), 1.05, 1e-4);
  EXPECT_NEAR(FigureOf(*fact, "excess_um"), 4000, 2);
  EXPECT_EQ(facts.Find("scale"), nullptr);
}

TEST(Stretch, ALineAParabolaAndAWaveAreNone) {
  const auto has = [](double (*off_mm)(double)) {
    return FactsOfRows(Marks(off_mm)).Find("stretch") != nullptr;
  };
  EXPECT_FALSE(has([](double x_mm) { return 0.05 * x_mm; }));
  EXPECT_FALSE(has([](double x_mm) { return 1e-4 * x_mm * x_mm; }));
  EXPECT_FALSE(has([](double x_mm) { return 0.1 * std::sin(x_mm / 20); }));
}

std::vector<Row> Heights(double (*off_mm)(double)) {
  std::vector<Row> rows;
  for (const double height_mm : {3, 5, 10, 50, 98}) {
    Row row{.campaign = "parts"};
    row.cmd_mm = {kUnknown, kUnknown, height_mm};
    row.n = {0, 0, 1};
    row.value_mm = off_mm(height_mm);
    rows.push_back(row);
  }
  return rows;
}

TEST(Fade, OffInProportionAndThenByAConstant) {
  const Facts facts =
      FactsOfRows(Heights([](double z_mm) { return 0.13 * std::min(z_mm, 10.0); }));
  const Fact* fact = facts.Find("stretch");
  ASSERT_NE(fact, nullptr);
  EXPECT_EQ(fact->word, "fades");
  EXPECT_EQ(FigureOf(*fact, "to_mm"), 10);
  EXPECT_NEAR(FigureOf(*fact, "excess_um"), 1300, 1e-6);
  EXPECT_EQ(facts.Find("scale"), nullptr);
  const auto has = [](double (*off_mm)(double)) {
    return FactsOfRows(Heights(off_mm)).Find("stretch") != nullptr;
  };
  EXPECT_FALSE(has([](double z_mm) { return 0.13 * z_mm; }));
  EXPECT_FALSE(has([](double) { return 1.3; }));
  // A constant, and two places that stand beside each other.
  std::vector<Row> rows = Heights([](double) { return 0.2; });
  rows[0].cmd_mm[2] = 4.9;
  rows[1].value_mm = 0.21;
  EXPECT_EQ(FactsOfRows(rows).Find("stretch"), nullptr);
}

TEST(Sizes, AConstantBesideAScaleIsToldFirst) {
  std::vector<Row> rows;
  for (const double size_mm : {25.4, 50.8, 127.0}) {
    Row row{.campaign = "squares"};
    row.cmd_mm[0] = size_mm;
    row.n = {1, 0, 0};
    row.value_mm = 0.0063 * size_mm - 0.8;
    rows.push_back(row);
  }
  const Facts facts = FactsOfRows(rows);
  const Fact* fact = facts.Find("offset");
  ASSERT_NE(fact, nullptr);
  EXPECT_NEAR(FigureOf(*fact, "change_um"), -800, 1e-6);
  EXPECT_NEAR(FigureOf(*fact, "factor"), 1.0063, 1e-9);
  EXPECT_EQ(facts.Find("scale"), nullptr);
}

// What each round moves its motors by, the next asks for again.
TEST(Levelling, CorrectionsThatDoubleAreToldFromTheMotorsAlone) {
  const auto factor_of = [](double again) {
    LevellingLog log;
    const std::vector<double> moved_mm = {-0.04, -0.04, 0.1, -0.02};
    std::vector<Row> rows;
    for (int round = 0; round < 2; ++round) {
      LevellingRound one{.home = std::to_string(round)};
      for (const double each_mm : moved_mm) {
        one.moved_mm.push_back(each_mm * (round == 0 ? 1 : again));
      }
      log.rounds.push_back(one);
      for (const double x_mm : {0, 100}) {
        rows.push_back(Row{.campaign = "g30", .kind = RowKind::kTouch});
        rows.back().cmd_mm = {x_mm, 0, 0};
        rows.back().n = {0, 0, 1};
        rows.back().value_mm = 1e-5 * x_mm;
        rows.back().home = one.home;
      }
    }
    const Facts facts = FactsOfRows(rows, {}, log);
    const Fact* fact = facts.Find("levelling");
    return fact == nullptr ? kUnknown : FigureOf(*fact, "factor");
  };
  EXPECT_NEAR(factor_of(2), 2, 1e-9);
  EXPECT_NEAR(factor_of(0.1), 0.1, 1e-9);
}

Row Corner(double x_mm, double y_mm, double z_mm, const std::string& campaign) {
  Row row{.campaign = campaign, .kind = RowKind::kTouch, .setup = "bed"};
  row.cmd_mm = {x_mm, y_mm, 0};
  row.dir = {kUnknown, kUnknown, -1};
  row.n = {0, 0, 1};
  row.value_mm = z_mm;
  return row;
}

TEST(MapChange, APlaneBetweenTwoMapsIsATilt) {
  std::vector<Row> rows;
  constexpr double kTwist_mm = 0.08, kLeft_mm = 0.004;
  for (const std::string name : {"first", "second"}) {
    for (const double x : {0, 1}) {
      for (const double y : {0, 1}) {
        const double tilted = name == "second" ? 0.1 + 0.12 * x - 0.09 * y : 0;
        const double sign = x == y ? 1 : -1;
        const double twist_mm = name == "second" ? kTwist_mm + kLeft_mm : kTwist_mm;
        rows.push_back(Corner(x, y, sign * twist_mm + tilted, name));
      }
    }
  }
  const Facts facts = FactsOfRows(rows);
  const Fact* fact = facts.Find("map_change");
  ASSERT_NE(fact, nullptr);
  EXPECT_NEAR(FigureOf(*fact, "shift_um"), 115, 1e-6);
  EXPECT_NEAR(FigureOf(*fact, "tilt_x_um"), 120, 1e-6);
  EXPECT_NEAR(FigureOf(*fact, "tilt_y_um"), -90, 1e-6);
  EXPECT_NEAR(FigureOf(*fact, "left_um"), 4, 1e-6);
}

// Three touches of each corner that are nothing but noise.
void AddCorners(const std::string& campaign, Rng* rng, std::vector<Row>* rows) {
  for (int i = 0; i < 12; ++i) {
    rows->push_back(Corner(i % 2, i / 2 % 2, 0.03 * rng->Normal(), campaign));
  }
}

TEST(MapChange, NoiseOfFourCornersIsNone) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Rng rng(seed, 0, "facts_shapes_test");
    std::vector<Row> rows;
    AddCorners("first", &rng, &rows);
    AddCorners("second", &rng, &rows);
    EXPECT_EQ(FactsOfRows(rows).Find("map_change"), nullptr) << seed;
  }
}

// A place that stands out in both maps is the bed's, though the second lies lower.
TEST(MapChange, WhatStandsOutInBothIsNoBadTouch) {
  std::vector<Row> rows;
  for (const std::string name : {"first", "second"}) {
    for (int i = 0; i < 5; ++i) {
      for (int k = 0; k < 5; ++k) {
        const double bump_mm = i == 3 && k == 2 ? 0.3 : 0;
        const double fine_mm = 0.004 * ((7 * i + 3 * k) % 5) / 5;
        rows.push_back(
            Corner(i, k, (name == "first" ? 6 : 1) + bump_mm + fine_mm, name));
      }
    }
  }
  const Facts facts = FactsOfRows(rows);
  EXPECT_EQ(facts.Find("outliers"), nullptr);
  ASSERT_NE(facts.Find("offset"), nullptr);
  EXPECT_NEAR(FigureOf(*facts.Find("offset"), "change_um"), -5000, 1e-6);
}

TEST(MapChange, AnotherShapeIsNone) {
  std::vector<Row> rows;
  for (const double x : {0, 1}) {
    for (const double y : {0, 1}) {
      rows.push_back(Corner(x, y, 0, "first"));
    }
  }
  for (const double x : {0, 1}) {
    for (const double y : {0, 1}) {
      rows.push_back(Corner(x, y, x == y ? 0.1 : -0.1, "second"));
    }
  }
  EXPECT_EQ(FactsOfRows(rows).Find("map_change"), nullptr);
}

Facts DeltaWith(std::array<double, 3> across_mm, double tower_x_mm = 0.001) {
  std::vector<Row> rows;
  const auto add = [&](const std::string& name, double z_mm) {
    rows.push_back(Corner(static_cast<double>(rows.size()), 0, z_mm, "delta"));
    rows.back().feature = "delta." + name;
  };
  add("c", 0.002);
  add("x", tower_x_mm);
  add("y", -0.003);
  add("z", 0.001);
  add("ox", across_mm[0]);
  add("oy", across_mm[1]);
  add("oz", across_mm[2]);
  return FactsOfRows(rows);
}

TEST(TowerHeights, OneTowerIsToldFromWhatAllShare) {
  const Fact* fact = nullptr;
  const Facts radial = DeltaWith({0.086, 0.086, -0.171});
  fact = radial.Find("tower_heights");
  ASSERT_NE(fact, nullptr);
  EXPECT_EQ(fact->axis, "z");
  EXPECT_THAT(fact->sentence, HasSubstr("further out or in"));

  const Facts angle = DeltaWith({0.323, -0.325, 0});
  fact = angle.Find("tower_heights");
  ASSERT_NE(fact, nullptr);
  EXPECT_EQ(fact->axis, "z");
  EXPECT_THAT(fact->sentence, HasSubstr("the angle of tower z"));

  const Facts rods = DeltaWith({0.2, 0.21, 0.19});
  fact = rods.Find("tower_heights");
  ASSERT_NE(fact, nullptr);
  EXPECT_EQ(fact->axis, "");
  EXPECT_NEAR(FigureOf(*fact, "mean_um"), 200, 1e-6);
}

TEST(TowerHeights, OfALevelDeltaAndOfOneNotCalibratedNothingIsSaid) {
  EXPECT_EQ(DeltaWith({0.004, 0.003, -0.002}).Find("tower_heights"), nullptr);
  EXPECT_EQ(DeltaWith({0.086, 0.086, -0.171}, 0.1).Find("tower_heights"), nullptr);
}

TEST(FineRatios, AreKnownToHalfAThousandth) {
  EXPECT_EQ(FineRatioOf(4000.0 / 4096, 1e-4).reading, "encoder_lines");
  EXPECT_EQ(FineRatioOf(4096.0 / 4000, 1e-4).reading, "encoder_lines");
  EXPECT_EQ(FineRatioOf(96.0 / 90, kUnknown).reading, "pixels_per_inch");
  EXPECT_EQ(FineRatioOf(0.9750, 1e-4).reading, "");
  EXPECT_EQ(FineRatioOf(4000.0 / 4096, 2e-3).reading, "");
}

}  // namespace
}  // namespace caltwin

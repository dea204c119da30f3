// What numbers say by themselves, against closed forms: rows are made to say one thing.

#include <cmath>
#include <string>
#include <vector>

#include <Eigen/QR>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/facts/ratios.h"
#include "sim/base/rng.h"
#include "tests/diagnosis/facts_of.h"

namespace caltwin {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

Row Touch(double x_mm, double y_mm, double value_mm) {
  Row row{
      .campaign = "t", .kind = RowKind::kTouch, .setup = "bed", .feature = "bed.top"};
  row.cmd_mm = {x_mm, y_mm, 0};
  row.dir[2] = -1;
  row.n = {0, 0, 1};
  row.value_mm = value_mm;
  return row;
}

Row Position(std::size_t axis, double at_mm, double value_mm, double sense = kUnknown) {
  Row row{.campaign = "p"};
  row.cmd_mm[axis] = at_mm;
  row.dir[axis] = sense;
  row.n = {0, 0, 0};
  row.n[axis] = 1;
  row.value_mm = value_mm;
  return row;
}

TEST(Facts, TwoTouchesOfEachPlaceAreRepeats) {
  const Facts facts = FactsOfRows({Touch(0, 0, 0.010),
                                   Touch(0, 0, 0.014),
                                   Touch(9, 0, -0.002),
                                   Touch(9, 0, 0.002)});

  const Fact* fact = facts.Find("repeatability");
  ASSERT_NE(fact, nullptr);
  // Squares about the means: 2 (2 um)^2 + 2 (2 um)^2, two degrees of freedom.
  EXPECT_NEAR(FigureOf(*fact, "sd_um"), std::sqrt(16.0 / 2), 1e-6);
}

TEST(Facts, ASingleFarReadingIsLeftOutAndLevelsAreNot) {
  std::vector<Row> one, levels;
  for (const double z : {0.10, 0.11, 0.10, 3.0, 0.10, 0.11, 0.10, 0.11}) {
    one.push_back(Touch(0, 0, z));
  }
  for (const double z :
       {0.106, 0.106, 2.2, 2.2, 1.5, 1.5, 0.100, 0.109, 0.125, 0.119}) {
    levels.push_back(Touch(0, 0, z));
  }

  const Facts facts_1 = FactsOfRows(one);
  const Fact* outlier = facts_1.Find("outliers");
  ASSERT_NE(outlier, nullptr);
  EXPECT_THAT(outlier->rows, ElementsAre(4));
  const Facts of_levels = FactsOfRows(levels);
  EXPECT_EQ(of_levels.Find("outliers"), nullptr);
  const Fact* scatter = of_levels.Find("homing_scatter");
  ASSERT_NE(scatter, nullptr);
  EXPECT_NEAR(FigureOf(*scatter, "range_um"), 2200 - 106, 10);
}

TEST(Facts, ADriftIsNoScatterAndScatterNoDrift) {
  std::vector<Row> falling, noise;
  Rng rng(1, 0, "facts.test");
  for (int i = 0; i < 12; ++i) falling.push_back(Touch(0, 0, 5 - 0.004 * i));
  for (int i = 0; i < 12; ++i) noise.push_back(Touch(0, 0, 5 + 0.002 * rng.Normal()));

  const Facts facts_2 = FactsOfRows(falling);
  const Fact* drift = facts_2.Find("drift");
  ASSERT_NE(drift, nullptr);
  EXPECT_NEAR(FigureOf(*drift, "change_um"), -44, 1e-6);
  EXPECT_EQ(FactsOfRows(noise).Find("drift"), nullptr);
}

// 200 series of noise alone: the tests of a trend are at 0.3 %.
TEST(Facts, NoiseAloneSaysNothing) {
  int alarms = 0;
  for (std::uint64_t k = 0; k < 200; ++k) {
    Rng rng(2, k, "facts.test");
    std::vector<Row> rows;
    for (int i = 0; i < 30; ++i) {
      rows.push_back(Touch(20 * (i % 5), 20 * (i / 5 % 3), 0.003 * rng.Normal()));
    }
    for (const Fact& fact : FactsOfRows(rows).all) alarms += fact.is_answer ? 1 : 0;
  }
  EXPECT_LE(alarms, 4);
}

TEST(Facts, HomingsScatterMoreThanTouchesOfOneHoming) {
  std::vector<Row> rows;
  const double zero_mm[] = {0.106, 2.212, 0.104, 0.121};
  for (int home = 0; home < 4; ++home) {
    for (const double off_mm : {-0.002, 0.002}) {
      rows.push_back(Touch(0, 0, zero_mm[home] + off_mm));
      rows.back().home = std::to_string(home);
    }
  }

  const Facts facts = FactsOfRows(rows);
  const Fact* homing = facts.Find("homing_scatter");
  ASSERT_NE(homing, nullptr);
  double mean = 0, squares = 0;
  for (const double zero : zero_mm) mean += zero / 4;
  for (const double zero : zero_mm) squares += (zero - mean) * (zero - mean);
  EXPECT_NEAR(FigureOf(*homing, "sd_um"), 1e3 * std::sqrt(squares / 3), 1);
  EXPECT_NEAR(FigureOf(*facts.Find("repeatability"), "sd_um"), std::sqrt(8.0), 1e-3);
}

TEST(Facts, FourCornersShowATwistAndNoPlaneDoes) {
  std::vector<Row> rows, tilted;
  for (const double x : {-1, 1}) {
    for (const double y : {-1, 1}) {
      for (const double off_mm : {-0.001, 0.001}) {
        rows.push_back(
            Touch(300 + 300 * x, 200 + 200 * y, 0.5 * x * y + 0.3 * x + off_mm));
        tilted.push_back(
            Touch(300 + 300 * x, 200 + 200 * y, 0.3 * x - 0.2 * y + off_mm));
      }
    }
  }

  const Facts facts_3 = FactsOfRows(rows);
  const Fact* twist = facts_3.Find("twist");
  ASSERT_NE(twist, nullptr);
  EXPECT_NEAR(FigureOf(*twist, "height_um"), 500, 1e-6);
  const Facts plane = FactsOfRows(tilted);
  EXPECT_EQ(plane.Find("twist"), nullptr);
  EXPECT_NEAR(FigureOf(*plane.Find("plane"), "slope_x_mrad"), 1, 1e-9);
  EXPECT_NEAR(FigureOf(*plane.Find("plane"), "slope_y_mrad"), -1, 1e-9);
}

// Least trimmed squares: two bad touches of 25, three of 49, one of nine.
TEST(Facts, FarTouchesOfAMeshCannotHideEachOther) {
  const struct {
    int side;
    std::vector<std::int64_t> bad;
  } meshes[] = {{5, {8, 17}}, {7, {3, 11, 49}}, {3, {5}}};
  for (const auto& mesh : meshes) {
    Rng rng(3, static_cast<std::uint64_t>(mesh.side), "facts.test");
    std::vector<Row> rows;
    for (int i = 0; i < mesh.side * mesh.side; ++i) {
      const int column = i % mesh.side, line = i / mesh.side;
      const double x = 40.0 * column, y = 40.0 * line;
      rows.push_back(Touch(x, y, 7e-4 * x - 4e-4 * y + 0.01 * rng.Normal()));
    }
    for (const std::int64_t row : mesh.bad)
      rows[static_cast<std::size_t>(row - 1)].value_mm += 3.8;

    const Facts facts_4 = FactsOfRows(rows);
    const Fact* fact = facts_4.Find("outliers");
    ASSERT_NE(fact, nullptr) << mesh.side;
    EXPECT_EQ(fact->rows, mesh.bad);
  }
}

TEST(Facts, ScaleAndReversalOfALine) {
  std::vector<Row> rows;
  for (int i = 0; i <= 7; ++i) {
    const double q = 20.0 * i;
    rows.push_back(Position(0, q, 0.001 * q - 0.010, 1));
    rows.push_back(Position(0, q, 0.001 * q + 0.010, -1));
    rows.push_back(Position(0, q, 0.001 * q + 0.011, -1));
  }

  const Facts facts = FactsOfRows(rows);
  EXPECT_NEAR(FigureOf(*facts.Find("scale"), "factor"), 1.001, 1e-6);
  EXPECT_NEAR(FigureOf(*facts.Find("reversal"), "gap_um"), 20.5, 0.01);
}

TEST(Facts, ASurplusIsNoScale) {
  std::vector<Row> rows;
  Rng rng(4, 0, "facts.test");
  for (const double q : {10, 20, 30, 40, 50}) {
    rows.push_back(Position(0, q, 0.2 + 0.01 * rng.Normal()));
  }

  const Facts facts = FactsOfRows(rows);
  const Fact* offset = facts.Find("offset");
  ASSERT_NE(offset, nullptr);
  EXPECT_NEAR(FigureOf(*offset, "change_um"), 200, 30);
  EXPECT_EQ(facts.Find("scale"), nullptr);
}

TEST(Facts, ReadingsThatLieOnALineExactlyHaveNoUncertainty) {
  const Facts facts =
      FactsOfRows({Position(0, 10, 0.5), Position(0, 20, 1.0), Position(0, 30, 1.5)});
  for (const FactFigure& figure : facts.Find("scale")->figures) {
    EXPECT_FALSE(Known(figure.sd)) << figure.key;
  }
}

TEST(Facts, OneAxissSenseIsSeenInAnother) {
  std::vector<Row> rows;
  for (int rep = 0; rep < 3; ++rep) {
    for (const double x : {0, 20, 40, 60}) {
      for (const double sense : {-1, 1}) {
        rows.push_back(Touch(x, 5, 4e-4 * x + 0.0075 * sense + 0.001 * (rep - 1)));
        rows.back().dir[0] = sense;
      }
    }
  }

  const Facts facts_5 = FactsOfRows(rows);
  const Fact* fact = facts_5.Find("cross_reversal");
  ASSERT_NE(fact, nullptr);
  EXPECT_EQ(fact->axis, "x");
  EXPECT_EQ(fact->word, "z");
  EXPECT_NEAR(FigureOf(*fact, "gap_um"), 15, 1e-6);
}

TEST(Facts, LatencyIsTheSlopeAgainstFeed) {
  std::vector<Row> rows;
  for (const double feed : {1, 2, 4, 6}) {
    for (const double off_mm : {-0.001, 0.001}) {
      rows.push_back(Touch(0, 0, -0.010 * feed + off_mm));
      rows.back().feed_mm_s = feed;
    }
  }
  const Facts facts = FactsOfRows(rows);
  EXPECT_NEAR(FigureOf(*facts.Find("latency"), "latency_ms"), 10, 1e-6);
}

// A square of side L whose Y leans to -X by c: diagonals differ by sqrt(2) L c.
TEST(Facts, DiagonalsOfASquareShowItsSkew) {
  constexpr double kSide_mm = 100, kAngle = 0.0035;
  const double off_mm = kSide_mm * kAngle / std::sqrt(2.0);
  std::vector<Row> rows;
  const auto add = [&](const std::string& setup,
                       std::array<double, 3> from,
                       std::array<double, 3> to,
                       double change_mm) {
    Row row{.campaign = "square", .setup = setup};
    const double length = std::hypot(to[0] - from[0], to[1] - from[1]);
    for (std::size_t k = 0; k < 3; ++k) row.n[k] = (to[k] - from[k]) / length;
    row.cmd_mm = from;
    rows.push_back(row);
    row.cmd_mm = to;
    row.value_mm = change_mm;
    rows.push_back(row);
  };
  add("AD", {0, 0, 0}, {kSide_mm, 0, 0}, 0);
  add("AC", {0, 0, 0}, {kSide_mm, kSide_mm, 0}, -off_mm);
  add("BD", {0, kSide_mm, 0}, {kSide_mm, 0, 0}, off_mm);

  const Facts facts_6 = FactsOfRows(rows);
  const Fact* skew = facts_6.Find("skew");
  ASSERT_NE(skew, nullptr);
  EXPECT_EQ(skew->axis, "C0Y");
  EXPECT_NEAR(FigureOf(*skew, "angle_mrad"), 1e3 * kAngle, 1e-6);
}

TEST(Facts, ATemperatureIsFollowedUpAndDown) {
  std::vector<Row> rows;
  for (const double temp_c : {20, 25, 30, 35, 40, 33, 28, 22}) {
    rows.push_back(Touch(0, 0, -0.0062 * (temp_c - 20) + 0.0005 * (rows.size() % 2)));
    rows.back().temp_frame_c = temp_c;
    rows.back().temp_bed_c = 60;
  }

  const Facts facts = FactsOfRows(rows);
  const Fact* fact = facts.Find("temperature");
  ASSERT_NE(fact, nullptr);
  EXPECT_EQ(fact->word, "frame");
  EXPECT_NEAR(FigureOf(*fact, "um_per_k"), -6.2, 0.05);
  EXPECT_EQ(facts.Find("drift"), nullptr);
}

struct Bed {
  std::vector<std::array<double, 2>> written{}, built{};
  std::vector<std::size_t> wired{};  ///< Motor that each output drives.
};

// A rigid beam or bed over its motors, levelled by firmware that believes `written`.
Facts Levelled(const Bed& bed, double slope_x, double slope_y) {
  std::vector<Row> rows;
  LevellingLog log{.pivots_mm = bed.written};
  double a = slope_x, b = slope_y;
  for (int round = 0; round < 3; ++round) {
    for (const double x : {20, 180}) {
      for (const double y : {30, 210}) {
        rows.push_back(Touch(x, y, a * x + b * y));
        rows.back().home = std::to_string(round + 1);
      }
    }
    LevellingRound moves{.home = std::to_string(round + 2)};
    Eigen::MatrixXd at(static_cast<Eigen::Index>(bed.built.size()), 3);
    Eigen::VectorXd moved(at.rows());
    for (std::size_t m = 0; m < bed.written.size(); ++m) {
      moves.moved_mm.push_back(-(a * bed.written[m][0] + b * bed.written[m][1]));
    }
    for (std::size_t m = 0; m < bed.built.size(); ++m) {
      const auto i = static_cast<Eigen::Index>(bed.wired[m]);
      at.row(i) << 1, bed.built[bed.wired[m]][0], bed.built[bed.wired[m]][1];
      moved[i] = moves.moved_mm[m];
    }
    const Eigen::VectorXd plane = at.colPivHouseholderQr().solve(moved);
    a += plane[1];
    b += plane[2];
    log.rounds.push_back(moves);
  }
  return FactsOfRows(rows, {}, log);
}

TEST(Facts, LevellingNamesASwapAndAMovedPivot) {
  const std::vector<std::array<double, 2>> three = {{-50, 18}, {150, 420}, {350, 18}};
  const Facts right = Levelled({three, three, {0, 1, 2}}, 1e-3, 3e-3);
  EXPECT_FALSE(right.Find("levelling")->is_answer);

  const Facts swapped = Levelled({three, three, {2, 1, 0}}, 3e-3, 1e-3);
  EXPECT_EQ(swapped.Find("levelling")->cause, "motors_swapped");
  EXPECT_EQ(swapped.Find("levelling")->cause_axis, "z1z3");

  std::vector<std::array<double, 2>> built = three;
  built[1][1] = 348;
  const Facts moved = Levelled({three, built, {0, 1, 2}}, 1e-3, 3e-3);
  const Fact* pivot = moved.Find("levelling");
  EXPECT_EQ(pivot->cause, "pivot_position");
  EXPECT_EQ(pivot->cause_axis, "z2");
  EXPECT_NEAR(pivot->parameters[1].value, -72, 3);
}

TEST(Facts, ACorrectionWithoutEffectStaysAsItWas) {
  const Facts facts =
      FactsOfRows({Touch(kUnknown, kUnknown, 0.135), Touch(kUnknown, kUnknown, 0.131)},
                  {},
                  {.differences_mm = {0.135, 0.131, 0.139}});
  EXPECT_EQ(facts.Find("levelling")->word, "no_effect");
}

TEST(Facts, APlaneThatIsTurnedByAThird) {
  std::vector<Row> rows;
  int line = 0;
  for (const auto& [x, y] : {std::pair{60, 0}, std::pair{0, 60}, std::pair{40, 40}}) {
    ++line;
    const double turn = 2 * M_PI / 3;
    const double went[] = {x * std::cos(turn) - y * std::sin(turn),
                           x * std::sin(turn) + y * std::cos(turn)};
    for (std::size_t k = 0; k < 2; ++k) {
      Row row = Position(k, k == 0 ? x : y, went[k] - (k == 0 ? x : y));
      row.cmd_mm = {static_cast<double>(x), static_cast<double>(y), kUnknown};
      row.place.line = line;
      rows.push_back(row);
    }
  }

  const Facts facts = FactsOfRows(rows);
  ASSERT_NE(facts.Find("turn"), nullptr);
  EXPECT_NEAR(FigureOf(*facts.Find("turn"), "angle_deg"), 120, 1e-6);
  EXPECT_EQ(facts.not_the_machine.reason, "settings");
}

TEST(Facts, WhatNothingDeterminesIsSaid) {
  const Facts facts = FactsOfRows({Touch(0, 0, 0.1), Touch(9, 9, 0.2)});
  EXPECT_THAT(facts.not_determined, ::testing::Contains("scale.z"));
  EXPECT_THAT(facts.not_determined, ::testing::Contains("uncertainty"));
  EXPECT_THAT(facts.at_one_place, ElementsAre("scale.z"));
  ASSERT_FALSE(facts.next.empty());
}

TEST(KnownRatio, WhatPeopleKnow) {
  EXPECT_EQ(KnownRatioOf(1.0 / 16, kUnknown).reading, "microsteps");
  EXPECT_EQ(KnownRatioOf(2, kUnknown).reading, "microsteps");
  EXPECT_THAT(KnownRatioOf(2, kUnknown).also, ::testing::Contains("diameter_radius"));
  EXPECT_EQ(KnownRatioOf(25.4, kUnknown).reading, "inches");
  EXPECT_EQ(KnownRatioOf(1.25, 0.001).reading, "lead");
  EXPECT_EQ(KnownRatioOf(-1, kUnknown).reading, "sign");
  EXPECT_EQ(KnownRatioOf(1.01, 0.001).reading, "");
  EXPECT_EQ(KnownRatioOf(1.4, 0.001).reading, "");
  EXPECT_THAT(KnownRatioOf(0.5, kUnknown).sentence, HasSubstr("steps/mm"));
}

// Deviations taken for positions: nothing that anybody should set.
TEST(Facts, WhatIsHardlyAnyOfWhatWasToldIsNoScale) {
  std::vector<Row> rows;
  for (const double at_mm : {50.0, 100.0, 150.0, 200.0}) {
    rows.push_back(Position(0, at_mm, 1e-3 * at_mm - at_mm));
  }

  const Facts facts = FactsOfRows(rows);

  EXPECT_EQ(facts.Find("scale"), nullptr);
  EXPECT_THAT(facts.not_determined, testing::Contains("scale.x"));
}

}  // namespace
}  // namespace caltwin

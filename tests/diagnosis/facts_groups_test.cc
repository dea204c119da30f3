// Facts of groups of readings, of what came before them and of the direction they came
// from, against closed forms.

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/rng.h"
#include "tests/diagnosis/facts_of.h"

namespace caltwin {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

Row Move(std::size_t axis, double told_mm, double off_mm, double sense = kUnknown) {
  Row row{.campaign = "moves", .flag = "move"};
  row.cmd_mm[axis] = told_mm;
  row.dir[axis] = sense;
  row.n[axis] = 1;
  row.value_mm = off_mm;
  return row;
}

Row Height(double x_mm, double y_mm, double z_mm, std::string campaign = "map") {
  Row row{.campaign = std::move(campaign),
          .kind = RowKind::kTouch,
          .setup = "bed",
          .feature = "bed.top"};
  row.cmd_mm = {x_mm, y_mm, kUnknown};
  row.dir = {kUnknown, kUnknown, -1};
  row.n = {0, 0, 1};
  row.value_mm = z_mm;
  return row;
}

TEST(FactsOfGroups, TwoGaugesThatTellTwoTiltsContradictEachOther) {
  std::vector<Row> rows;
  for (const double x : {0.0, 100.0, 200.0}) {
    for (const double y : {0.0, 100.0}) {
      rows.push_back(Height(x, y, 0.001 * x, "gauge_probe"));
      rows.push_back(Height(x, y, 0.0, "gauge_dial"));
    }
  }
  const Facts facts = FactsOfRows(rows);

  const Fact* fact = facts.Find("contradiction");
  ASSERT_NE(fact, nullptr);
  EXPECT_EQ(fact->axis, "x");
  EXPECT_NEAR(FigureOf(*fact, "slope_mrad"), -1, 1e-9);
  EXPECT_THAT(facts.not_determined, Contains("cause"));
}

TEST(FactsOfGroups, GaugesThatAgreeDoNot) {
  std::vector<Row> rows;
  for (const double x : {0.0, 100.0, 200.0}) {
    for (const double y : {0.0, 100.0}) {
      rows.push_back(Height(x, y, 0.001 * x, "gauge_probe"));
      rows.push_back(Height(x, y, 0.001 * x + 0.5, "gauge_dial"));
    }
  }
  EXPECT_EQ(FactsOfRows(rows).Find("contradiction"), nullptr);
}

TEST(FactsOfGroups, TrialsMustGoAsTheirStepsPerMm) {
  DataHeader header;
  header.settings["a"].steps_per_mm = {{"x", 80}};
  header.settings["b"].steps_per_mm = {{"x", 160}};
  const auto trials = [&](double at_80, double at_160) {
    std::vector<Row> rows = {Move(0, 100, 100 * (at_80 - 1)),
                             Move(0, 100, 100 * (at_160 - 1))};
    rows[0].settings = "a";
    rows[1].settings = "b";
    return FactsOfRows(rows, header);
  };

  EXPECT_EQ(trials(0.5, 1.0).Find("contradiction"), nullptr);
  const Facts stalls = trials(0.5, 0.8);
  ASSERT_NE(stalls.Find("contradiction"), nullptr);
  EXPECT_THAT(stalls.not_determined, Contains("scale.x"));
}

TEST(FactsOfHistory, AnAmountThatComesWithAChangeOfAxisIsTheFirmwares) {
  Rng rng(3, 0, "history.test");
  std::vector<Row> rows;
  for (int i = 0; i < 16; ++i) {
    const bool is_changed = i > 0 && (i / 2) % 2 != ((i - 1) / 2) % 2;
    rows.push_back(Move(static_cast<std::size_t>((i / 2) % 2),
                        10,
                        (is_changed ? 0.1 : 0) + 0.002 * rng.Normal(),
                        1));
  }
  const Facts facts = FactsOfRows(rows);

  const Fact* fact = facts.Find("offset");
  ASSERT_NE(fact, nullptr);
  EXPECT_EQ(fact->word, "change_of_axis");
  EXPECT_NEAR(FigureOf(*fact, "change_um"), 100, 4);
  EXPECT_EQ(facts.not_the_machine.reason, "firmware");
}

// A bowed bed under a probe that reads 0.03 mm more where X arrived from below.
TEST(FactsOfArrival, StripesOfAMapTouchedToAndFro) {
  const auto map = [](double gap_mm) {
    Rng rng(4, 0, "arrival.test");
    std::vector<Row> rows;
    for (int j = 0; j < 6; ++j) {
      for (int i = 0; i < 6; ++i) {
        const bool is_back = j % 2 == 1;
        const double x_mm = 20.0 * (is_back ? 5 - i : i), y_mm = 20.0 * j;
        // The first node of a line is come upon in Y alone: X stands as it did.
        const double sense = (i == 0 ? !is_back : is_back) ? -1 : 1;
        rows.push_back(Height(
            x_mm,
            y_mm,
            1e-5 * std::pow(x_mm - 50, 2) + gap_mm * sense / 2 + 0.001 * rng.Normal()));
      }
    }
    return FactsOfRows(rows);
  };

  const Facts striped = map(0.03);
  const Fact* fact = striped.Find("cross_reversal");
  ASSERT_NE(fact, nullptr);
  EXPECT_EQ(fact->axis, "x");
  EXPECT_NEAR(FigureOf(*fact, "gap_um"), 30, 2);
  EXPECT_EQ(map(0).Find("cross_reversal"), nullptr);
}

TEST(FactsOfMotion, NothingMovesUntilThePlayIsTakenUp) {
  std::vector<Row> rows;
  for (int k = 1; k <= 12; ++k) {
    const double told_mm = 0.01 * k;
    rows.push_back(Move(2, told_mm, std::max(0.0, told_mm - 0.045) - told_mm, 1));
  }
  const Facts facts = FactsOfRows(rows);

  const Fact* fact = facts.Find("reversal");
  ASSERT_NE(fact, nullptr);
  EXPECT_EQ(fact->word, "dead_zone");
  EXPECT_NEAR(FigureOf(*fact, "gap_um"), 45, 1e-6);
}

TEST(FactsOfMotion, EachMoveEndsShortByOneAmountBesideAScale) {
  std::vector<Row> rows;
  Rng rng(5, 0, "per_move.test");
  for (const double told_mm : {5.0, 10.0, 20.0, 40.0, 80.0, 100.0}) {
    rows.push_back(Move(0, told_mm, 0.004 * told_mm - 0.2 + 0.002 * rng.Normal()));
  }
  const Facts facts = FactsOfRows(rows);

  const Fact* lost = facts.Find("offset");
  ASSERT_NE(lost, nullptr);
  EXPECT_NEAR(FigureOf(*lost, "change_um"), -200, 8);
  ASSERT_NE(facts.Find("scale"), nullptr);
}

TEST(FactsOfLatency, TheFasterTheTouchTheLaterTheTrigger) {
  std::vector<Row> rows;
  for (const double feed_mm_s : {1.0, 2.0, 5.0, 10.0}) {
    for (int k = 0; k < 3; ++k) {
      rows.push_back(Height(0, 0, 0.2 - 0.004 * feed_mm_s + 0.0005 * (k - 1)));
      rows.back().feed_mm_s = feed_mm_s;
    }
  }
  const Facts facts = FactsOfRows(rows);

  const Fact* fact = facts.Find("latency");
  ASSERT_NE(fact, nullptr);
  EXPECT_NEAR(FigureOf(*fact, "latency_ms"), 4, 0.2);
}

// Steps of 1.05 mm, alike to 20 um: what a reading repeats to is what they differ by.
TEST(FactsOfRepeats, AStaircaseIsNoScatter) {
  Rng rng(3, 0, "staircase");
  std::vector<Row> rows;
  for (int i = 0; i < 10; ++i) {
    const double reading_mm = -1.05 * i + 0.02 * rng.Normal();
    rows.push_back(Height(100, 100, std::round(reading_mm * 1e3) / 1e3));
  }

  const Facts facts = FactsOfRows(rows);

  const Fact* fact = facts.Find("drift");
  ASSERT_NE(fact, nullptr);
  EXPECT_NEAR(FigureOf(*fact, "change_um"), -9450, 90);
  EXPECT_LT(fact->figures[0].sd, 60);
}

// Nine places touched six times, the machine shifted by 0.1 mm after the first round.
TEST(FactsOfOutliers, RoundsBeforeAStepAreNoBadTouches) {
  Rng rng(4, 0, "step");
  std::vector<Row> rows;
  for (int round = 0; round < 6; ++round) {
    for (int i = 0; i < 9; ++i) {
      const double step_mm = round == 0 ? 0 : 0.1;
      const int column = i % 3, line = i / 3;
      rows.push_back(
          Height(40.0 * column, 40.0 * line, step_mm + 0.002 * rng.Normal()));
    }
  }
  EXPECT_EQ(FactsOfRows(rows).Find("outliers"), nullptr);

  rows[47].value_mm += 0.3;  // One more, that is bad.
  const Facts facts = FactsOfRows(rows);
  const Fact* fact = facts.Find("outliers");
  ASSERT_NE(fact, nullptr);
  EXPECT_THAT(fact->rows, testing::ElementsAre(48));
}

// Two sizes that are both 20 mm short: no scale, and no line is as wide.
TEST(FactsOfMotion, AFixedLackThatNoWallIsWideIsNotDetermined) {
  std::vector<Row> rows;
  for (const double told_mm : {90.0, 110.0}) {
    Row row{.campaign = "sizes"};
    row.cmd_mm[0] = told_mm;
    row.n[0] = 1;
    row.value_mm = -20;
    rows.push_back(row);
    rows.push_back(row);
  }

  const Facts facts = FactsOfRows(rows);

  EXPECT_EQ(facts.Find("scale"), nullptr);
  EXPECT_THAT(facts.not_determined, Contains("scale.x"));
  EXPECT_THAT(facts.not_determined, Contains("cause"));
}

// By ISO 230-1 a turn of Y about Z is + counter-clockwise: Y then leans towards -X.
TEST(FactsOfLengths, SayWhereTheSecondAxisLeans) {
  constexpr double kAngle = 5e-3, kSide_mm = 1000;
  std::vector<Row> rows;
  const auto add = [&](double x_mm, double y_mm, double to_x_mm, double to_y_mm) {
    Row row{.campaign = "squares",
            .setup = fmt::format("{}", rows.size()),
            .flag = "length"};
    const double dx_mm = to_x_mm - x_mm, dy_mm = to_y_mm - y_mm;
    const double length_mm = std::hypot(dx_mm, dy_mm);
    row.n = {dx_mm / length_mm, dy_mm / length_mm, 0};
    row.cmd_mm = {x_mm, y_mm, 0};
    rows.push_back(row);
    row.cmd_mm = {to_x_mm, to_y_mm, 0};
    row.value_mm = std::hypot(dx_mm - kAngle * dy_mm, dy_mm) - length_mm;
    rows.push_back(row);
  };
  add(0, 0, kSide_mm, 0);
  add(0, 0, 0, kSide_mm);
  add(0, 0, kSide_mm, kSide_mm);
  add(kSide_mm, 0, 0, kSide_mm);

  const Facts facts = FactsOfRows(rows);

  const Fact* fact = facts.Find("skew");
  ASSERT_NE(fact, nullptr);
  EXPECT_NEAR(FigureOf(*fact, "angle_mrad"), 5, 0.05);
  EXPECT_EQ(fact->word, "-x");
  EXPECT_EQ(facts.Find("scale"), nullptr) << "what a side should be nobody said";
}

// What an axis needs, by trials at several settings: steps / (read / told) of each.
TEST(FactsOfGroups, TrialsThatAgreeSayWhatTheAxisNeeds) {
  constexpr double kNeeds = 401.3;
  DataHeader header;
  std::vector<Row> rows;
  for (const double steps : {399.0, 400.0, 401.0, 402.0}) {
    const std::string id = fmt::format("{:g}", steps);
    header.settings[id].steps_per_mm["x"] = steps;
    Row row = Move(0, 250, 250 * (steps / kNeeds - 1));
    row.settings = id;
    rows.push_back(row);
  }

  const Facts facts = FactsOfRows(rows, header);

  const Fact* fact = facts.Find("scale");
  ASSERT_NE(fact, nullptr);
  EXPECT_NEAR(FigureOf(*fact, "steps_per_mm"), kNeeds, 1e-6);
  EXPECT_THAT(facts.not_determined, testing::Not(Contains("scale.x")));
}

// Three switches, each reading behind a homing of its own.
TEST(FactsOfGroups, SwitchesAreComparedFromHomingToHoming) {
  Rng rng(8, 0, "switches");
  std::vector<Row> rows;
  for (const auto& [name, sd_mm] : {std::pair("a", 0.04), std::pair("b", 0.008)}) {
    for (int i = 0; i < 24; ++i) {
      Row row{.campaign = name, .home = std::to_string(i)};
      row.cmd_mm[0] = 0;
      row.n[0] = 1;
      row.value_mm = sd_mm * rng.Normal();
      rows.push_back(std::move(row));
    }
  }

  const Facts facts = FactsOfRows(rows);

  for (const Fact& fact : facts.all) {
    if (fact.id != "homing_scatter") continue;
    const double sd_um = fact.word == "a" ? 40 : 8;
    EXPECT_NEAR(fact.figures[0].value, sd_um, 4 * fact.figures[0].sd) << fact.word;
    EXPECT_EQ(fact.is_answer, fact.word == "a");
  }
  EXPECT_NE(facts.Find("homing_scatter"), nullptr);
}

// Two motors on a line along X level along X alone.
TEST(FactsOfLevelling, WhatLiesAcrossTwoMotorsStays) {
  const std::vector<Row> rows = {Height(20, 150, 2.5101),
                                 Height(20, 150, 2.5110),
                                 Height(250, 0, 1.6016),
                                 Height(250, 0, 1.6025),
                                 Height(250, 250, 2.3816),
                                 Height(250, 250, 2.3825)};

  const Facts facts = FactsOfRows(rows, {}, {.pivots_mm = {{340, 150}, {-50, 150}}});
  const Fact* fact = facts.Find("levelling");
  ASSERT_NE(fact, nullptr);
  EXPECT_EQ(fact->axis, "y");
  EXPECT_NEAR(FigureOf(*fact, "slope_y_mrad"), 3.12, 1e-3);

  const LevellingLog three{.pivots_mm = {{340, 150}, {-50, 150}, {100, 0}}};
  EXPECT_EQ(FactsOfRows(rows, {}, three).Find("levelling"), nullptr);
}

// Three bad readings of the first sweep over many places are no step of the machine.
TEST(FactsOfOutliers, AFewBadReadingsOfOneSweepStayBad) {
  Rng rng(6, 0, "sweeps");
  std::vector<Row> rows;
  for (int sweep = 0; sweep < 4; ++sweep) {
    for (int i = 0; i < 25; ++i) {
      const int column = i % 5, line = i / 5;
      rows.push_back(Height(40.0 * column, 40.0 * line, 0.002 * rng.Normal()));
    }
  }
  rows[2].value_mm += 0.2;
  rows[8].value_mm -= 0.3;
  rows[19].value_mm += 0.08;

  const Facts facts = FactsOfRows(rows);

  const Fact* fact = facts.Find("outliers");
  ASSERT_NE(fact, nullptr);
  EXPECT_THAT(fact->rows, testing::ElementsAre(3, 9, 20));
  EXPECT_EQ(facts.Find("jump"), nullptr);
}

// Ten readings that are all the same say nothing of a step of 1 mm.
TEST(FactsOfRepeats, ReadingsThatAreAllAlikeHaveNoStep) {
  const Facts facts = FactsOfRows(std::vector<Row>(10, Height(100, 100, 2.5)));

  const Fact* fact = facts.Find("repeatability");
  if (fact != nullptr) EXPECT_LT(FigureOf(*fact, "sd_um"), 1);
}

// The same travel whatever was set: no trial says what the axis needs.
TEST(FactsOfTrials, TravelThatDoesNotFollowTheSettingTellsNoNeed) {
  DataHeader header;
  std::vector<Row> rows;
  for (const double steps : {80.0, 82.0}) {
    const std::string id = fmt::format("{:g}", steps);
    header.settings[id].steps_per_mm["x"] = steps;
    Row row = Move(0, 100, 0);
    row.settings = id;
    rows.push_back(row);
  }

  const Facts facts = FactsOfRows(rows, header);

  for (const Fact& fact : facts.all) EXPECT_NE(fact.word, "trials") << fact.sentence;
}

// A frame that warms over hours climbs as evenly as a staircase.
TEST(FactsOfRepeats, ReadingsFarApartInTimeAreNoStaircase) {
  Rng rng(9, 0, "warming");
  std::vector<Row> rows;
  for (int i = 0; i < 8; ++i) {
    rows.push_back(Height(100, 100, 0.03 * i + 0.0015 * rng.Normal()));
    rows.back().t_s = 900.0 * i;
  }

  const Facts facts = FactsOfRows(rows);
  const Fact* fact = facts.Find("drift");
  ASSERT_NE(fact, nullptr);
  EXPECT_NE(fact->word, "staircase");
}

}  // namespace
}  // namespace caltwin

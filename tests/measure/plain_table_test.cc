#include "sim/measure/import/plain_table.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/input_error.h"
#include "sim/measure/import/import.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;

Imported Read(const std::string& text, const ImportOptions& options = {}) {
  return ImportText("table", text, "f", options);
}

TEST(PlainTable, CommandedAndMeasured) {
  const Imported imported = Read("axis,told_mm,moved_mm\nX,20,9.98\nZ,40,2.51\n");

  ASSERT_THAT(imported.table.rows, SizeIs(2));
  EXPECT_TRUE(imported.is_deviation);
  EXPECT_EQ(imported.table.rows[1].cmd_mm[2], 40);
  EXPECT_EQ(imported.table.rows[1].n[2], 1);
  EXPECT_NEAR(imported.table.rows[1].value_mm, -37.49, 1e-9);
  EXPECT_EQ(imported.table.rows[0].flag, "move");
}

TEST(PlainTable, APairOfColumnsAnAxisAndSeveralRuns) {
  const Imported pairs = Read("X cmd,X meas,Y cmd,Y meas\n10,10.1,20,20.3\n");
  ASSERT_THAT(pairs.table.rows, SizeIs(2));
  EXPECT_NEAR(pairs.table.rows[1].value_mm, 0.3, 1e-9);
  EXPECT_EQ(pairs.table.rows[1].cmd_mm[1], 20);

  const Imported runs = Read("nominal,measured 1,measured 2\n10,10.1,10.2\n");
  EXPECT_THAT(runs.table.rows, SizeIs(2));
}

TEST(PlainTable, HeightsOfPlacesAndFeedsAsInGCode) {
  const Imported imported = Read("x;y;height;feed\n1,5;2;0,25;120\n");

  ASSERT_THAT(imported.table.rows, SizeIs(1));
  const Row& row = imported.table.rows[0];
  EXPECT_EQ(row.kind, RowKind::kTouch);
  EXPECT_EQ(row.cmd_mm[0], 1.5);
  EXPECT_EQ(row.value_mm, 0.25);
  EXPECT_EQ(row.feed_mm_s, 2);
}

TEST(PlainTable, UnitsOfHeadingsAreConverted) {
  const Imported imported = Read("axis,approach,dial [in]\nX,+,-0.0191\nX,-,0.0002\n");

  ASSERT_THAT(imported.table.rows, SizeIs(2));
  EXPECT_NEAR(imported.table.rows[0].value_mm, -0.48514, 1e-9);
  EXPECT_EQ(imported.table.rows[0].dir[0], 1);
  EXPECT_EQ(imported.table.rows[1].dir[0], -1);
}

// An ISO 230 sheet as people keep it: positions in mm, what is off in um, both senses.
TEST(PlainTable, ColumnsForwardAndBackwardAreTheSenses) {
  const Imported imported =
      Read("target_mm,forward_um,backward_um\n0,-27,-30\n25,-7.5,-9\n50,19.8,17\n");

  ASSERT_THAT(imported.table.rows, SizeIs(6));
  EXPECT_NEAR(imported.table.rows[0].value_mm, -0.027, 1e-12);
  EXPECT_EQ(imported.table.rows[0].dir[0], 1);
  EXPECT_EQ(imported.table.rows[3].dir[0], -1);
  EXPECT_EQ(imported.table.rows[3].cmd_mm[0], 0);
  EXPECT_EQ(imported.table.rows[0].campaign, imported.table.rows[3].campaign);

  const Imported positions =
      Read("target,forward,return\n10,9.99,10.03\n20,19.98,20.02\n");
  EXPECT_NEAR(positions.table.rows[0].value_mm, -0.01, 1e-12);
  EXPECT_EQ(positions.table.rows[2].dir[0], -1);
  // Front and back of a bed are no senses.
  EXPECT_FALSE(Known(Read("told,front,back\n10,9.9,10.1\n20,19.9,20.1\n30,29.8,30.3\n")
                         .table.rows[0]
                         .dir[0]));
}

TEST(PlainTable, ADeviationMustSayItsUnit) {
  EXPECT_THAT([] { Read("target,error\n10,3\n"); },
              ::testing::ThrowsMessage<InputError>(HasSubstr("nothing says the unit")));
  const Imported imported = Read("target,error\n10,3\n", {.unit = "um"});
  EXPECT_NEAR(imported.table.rows[0].value_mm, 0.003, 1e-12);
}

TEST(PlainTable, HeadingsThatSayTooLittleAreListed) {
  EXPECT_THAT([] { Read("foo,bar\n1,2\n"); },
              ::testing::ThrowsMessage<InputError>(HasSubstr("1 'foo', 2 'bar'")));
}

// Found by a fuzzer: one line of two says what it is of.
TEST(PlainTable, ALineMayHaveNoLabel) {
  const Imported imported = Read("part,told,moved\n,10,9.9\nrail,20,19.9\n");

  ASSERT_THAT(imported.table.rows, SizeIs(2));
  for (const Row& row : imported.table.rows) EXPECT_THAT(row.extra, SizeIs(1));
}

TEST(PlainTable, MarkdownAndHtml) {
  EXPECT_EQ(WithoutMarkup("words\n| a | b |\n|---|---|\n| 1 | 2 |\n"),
            "\na\tb\n\n1\t2\n");
  EXPECT_EQ(WithoutMarkup(
                "<table><tr><th>a</th><th>b</th></tr><tr><td>1</td><td>2</td></tr>"),
            "a\tb\n1\t2\n");
  EXPECT_EQ(WithoutMarkup("a,b\n1,2\n"), "a,b\n1,2\n");
  EXPECT_THAT(Read("| nominal | measured |\n|--|--|\n| 20 | 20.2 |\n").table.rows,
              SizeIs(1));
}

TEST(ScrewTable, PositionsAndCorrectionsOfLinuxCnc) {
  const std::string positions =
      "0 0.001 -0.001\n50 50.011 50.009\n100 100.021 100.019\n";
  const std::string corrections =
      "0 -0.001 0.001\n50 -0.011 -0.009\n100 -0.021 -0.019\n";
  for (const std::string& text : {positions, corrections}) {
    const Imported imported = ImportText("screw-table", text, "y.comp", {});
    ASSERT_THAT(imported.table.rows, SizeIs(6));
    EXPECT_EQ(imported.table.rows[2].cmd_mm[1], 100);
    EXPECT_EQ(imported.table.rows[2].dir[1], 1);
    EXPECT_NEAR(imported.table.rows[2].value_mm, 0.021, 1e-9) << text;
    EXPECT_NEAR(imported.table.rows[3].value_mm, -0.001, 1e-9) << text;
  }
}

TEST(ScrewTable, CentroidCountsNeedTheLengthOfACount) {
  const std::string text = "2 -1000\n0\n-10\n-20\n";
  EXPECT_THAT([&] { ImportText("screw-table", text, "cnc-x.tab", {}); },
              ::testing::ThrowsMessage<InputError>(HasSubstr("--step-mm")));
  const Imported imported =
      ImportText("screw-table", text, "cnc-x.tab", {.step_mm = 0.001});
  ASSERT_THAT(imported.table.rows, SizeIs(3));
  EXPECT_EQ(imported.table.rows[2].cmd_mm[0], -1);
  EXPECT_NEAR(imported.table.rows[2].value_mm, 0.020, 1e-12);
  EXPECT_THAT(
      [&] {
        ImportText("screw-table", "0 0\n-10\n-20\n", "cnc-x.tab", {.step_mm = 0.001});
      },
      ::testing::ThrowsMessage<InputError>(
          HasSubstr("cnc-x.tab:1:1: 0 intervals over 0 counts of travel")));
}

TEST(PrinterLint, WhatContradictsItself) {
  const Imported towers =
      ImportText("printer-cfg",
                 "[stepper_a]\nstep_distance: .0125\n[stepper_b]\n"
                 "step_distance: .0125\n[stepper_c]\nstep_distance: .0025\n",
                 "f",
                 {});
  ASSERT_THAT(towers.notes, SizeIs(1));
  EXPECT_EQ(towers.notes[0].what, "step_distance");
  EXPECT_EQ(towers.notes[0].place.line, 6);
  EXPECT_THAT(
      [] { ImportText("printer-cfg", "[stepper_a]\nstep_distance: .0125\n", "f", {}); },
      ::testing::ThrowsMessage<InputError>(HasSubstr("nothing in it contradicts")));
}

}  // namespace
}  // namespace caltwin

// Tables among prose, sentences of sizes, squares by their diagonals, maps in XML.

#include "sim/measure/import/text_table.h"

#include <cmath>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/input_error.h"
#include "sim/measure/import/import.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::ThrowsMessage;

Imported Read(const std::string& text) {
  return ImportText("table", text, "f", {});
}

TEST(TextTable, IsFoundAmongProseAtItsOwnLines) {
  const std::string text =
      "My router loses something.\n\n"
      "told moved\n"
      "10 9.8\n"
      "20 19.8\n"
      "30 29.8\n\n"
      "Thanks for any help!\n";

  const std::string table = TableInText(text);
  EXPECT_THAT(table, HasSubstr("told\tmoved\n10\t9.8\n"));
  EXPECT_TRUE(table.starts_with("\n\n"));  // Messages name the line of the file.
  EXPECT_THAT(Read(text).table.rows, SizeIs(3));
}

// Two tables of one heading are two campaigns, named after the lines before them.
TEST(TextTable, EveryTableOfATextIsRead) {
  const Imported imported = Read(
      "Checked with a scale.\n\nlead 300\n"
      "pitch set  turns  should be  carriage went\n"
      "1.0        50      50.0       48.8\n"
      "2.0        50     100.0       97.6  (again, other end)\n\n"
      "lead 293\n"
      "1.0        50      50.0       50.0\n"
      "2.0        50     100.0      100.0\n");
  ASSERT_THAT(imported.table.rows, SizeIs(4));
  EXPECT_EQ(imported.table.rows[0].campaign, "lead_300");
  EXPECT_EQ(imported.table.rows[3].campaign, "lead_293");
  // Of what may have been told the column nearest to what was read.
  EXPECT_EQ(imported.table.rows[1].cmd_mm[0], 100);
  EXPECT_NEAR(imported.table.rows[1].value_mm, -2.4, 1e-9);
}

TEST(TextTable, LostMotionInInchesOfTheAxisThatItsTitleNames) {
  const Imported imported = Read(
      "Everything in inches.\nlost motion = from plus less from minus\n\n"
      "axis  jog    dial\n"
      "Y     0.100  .0125\n"
      "Y     2.000  .012\n"
      "X     0.500  .0005\n");
  ASSERT_THAT(imported.table.rows, SizeIs(6));
  EXPECT_EQ(imported.table.rows[0].dir[1], 1);
  EXPECT_EQ(imported.table.rows[0].value_mm, 0);
  EXPECT_EQ(imported.table.rows[1].dir[1], -1);
  EXPECT_NEAR(imported.table.rows[1].value_mm, 0.0125 * 25.4, 1e-9);
}

TEST(TextTable, ColumnsOfNumberedRunsWereRead) {
  const Imported imported = Read(
      "X commanded;mark run 1;mark run 2\n0;0.0;0.1\n20;20.1;20.0\n40;40.2;40.1\n");
  EXPECT_THAT(imported.table.rows, SizeIs(6));
}

TEST(TextTable, WhatWasSetBesideWhatIsOffPartsTheRows) {
  const Imported imported = Read(
      "fade height set,height in slicer mm,too high by mm\n10,3,0.4\n10,5,0.6\n"
      "10,50,1.3\n0,10,0\n0,50,0\n0,98,0\nprobe z offset,-1.35,\n");
  ASSERT_THAT(imported.table.rows, SizeIs(6));
  EXPECT_EQ(imported.table.rows[0].campaign, "10");
  EXPECT_EQ(imported.table.rows[5].campaign, "0");
  EXPECT_EQ(imported.table.rows[2].cmd_mm[2], 50);
  EXPECT_NEAR(imported.table.rows[2].value_mm, 1.3, 1e-12);
}

TEST(TextTable, WhatIsTooShortCountsTheOtherWay) {
  const Imported imported =
      Read("slicer height (mm),too low (mm)\n10,0.02\n50,0.1\n100,0.2\n");
  ASSERT_THAT(imported.table.rows, SizeIs(3));
  EXPECT_EQ(imported.table.rows[1].cmd_mm[2], 50);
  EXPECT_NEAR(imported.table.rows[1].value_mm, -0.1, 1e-12);
  EXPECT_NEAR(
      Read("told,too long (mm)\n10,0.02\n50,0.1\n").table.rows[1].value_mm, 0.1, 1e-12);
}

TEST(TextTable, OtherMachinesAndSettingsSayNothingOfTheReadings) {
  const std::string table = "told (mm)  dial (mm)\n10  0.02\n50  0.1\n100  0.2\n";
  EXPECT_EQ(Read("Settings: backlash: 0 in the firmware\n\n" + table).table.rows.size(),
            3U);
  const Imported metric = Read(
      "My other machine has everything in inches.\n\ntold,read\n10,10.02\n"
      "20,20.04\n30,30.06\n");
  EXPECT_EQ(metric.table.rows[0].cmd_mm[0], 10);
}

TEST(TextTable, ATitleNamesAnAxisWhereItBeginsWithIt) {
  const std::string table = "told  read\n10  10.1\n20  20.2\n30  30.3\n";
  const Imported imported =
      Read("lubricated the Z screw\n" + table + "\nY, loaded\n" + table);
  ASSERT_THAT(imported.table.rows, SizeIs(6));
  EXPECT_EQ(imported.table.rows[0].n[0], 1);
  EXPECT_EQ(imported.table.rows[5].n[1], 1);
  EXPECT_EQ(imported.table.rows[0].campaign, "lubricated_the_z_screw");
}

TEST(TextTable, ATableThatCannotBeReadLeavesTheOthers) {
  const Imported imported = Read(
      "minute  temperature\n0  20\n1  22\n2  24\n3  26\n\nX axis:\n"
      "commanded  measured\n10  10.1\n50  50.5\n");
  EXPECT_THAT(imported.table.rows, SizeIs(2));
}

TEST(TextTable, ASpeedIsNoLength) {
  EXPECT_THROW(Read("switches,leadscrew rpm\n1,297\n2,148\n3,118\n4,99\n"), InputError);
}

TEST(TextTable, ADamagedLineIsNotLost) {
  // Whatever becomes of the file, two of three readings are no answer.
  EXPECT_THAT(TableInText("told moved\n10 9.8\n20 19.8 ?? 7\n30 29.8\n"), IsEmpty());
}

TEST(TextTable, ProseIsNoTable) {
  EXPECT_THAT(TableInText("Bought it in 2019, it has 3 axes.\nIt never worked.\n"),
              IsEmpty());
}

TEST(Sentences, SayWhatWasDrawnAndWhatCameOut) {
  const Imported imported =
      Read("drew 40 x 40, burned 20 x 20\ndrew 60 wide, burned 30\n");

  ASSERT_THAT(imported.table.rows, SizeIs(3));
  EXPECT_EQ(imported.table.rows[0].cmd_mm[0], 40);
  EXPECT_EQ(imported.table.rows[1].cmd_mm[1], 40);
  EXPECT_NEAR(imported.table.rows[2].value_mm, -30, 1e-9);
}

TEST(Sentences, AnArrowStandsBetweenWhatWasDrawnAndWhatCame) {
  const Imported imported = Read(
      "Sizes by calliper.\n\nfirst try:\n  5 inch square -> 5\n"
      "  2 inch square -> 1.98\n  1 inch square -> 97.5 (hundredths)\n\n"
      "second try:\n  30 mm square -> 30.2\n");
  ASSERT_THAT(imported.table.rows, SizeIs(4));
  EXPECT_EQ(imported.table.rows[0].campaign, "first_try");
  EXPECT_NEAR(imported.table.rows[1].cmd_mm[0], 50.8, 1e-9);
  EXPECT_NEAR(imported.table.rows[2].value_mm, -0.025 * 25.4, 1e-9);
  EXPECT_NEAR(imported.table.rows[3].value_mm, 0.2, 1e-9);

  const Imported both = Read("1 inch -> 25.5 mm\n2 inch -> 51 mm\n4 inch -> 102 mm\n");
  EXPECT_NEAR(both.table.rows[0].value_mm, 0.1, 1e-9);
}

TEST(Sentences, ACubeAboveItsSides) {
  const Imported imported = Read("30 mm cube\nX 30.05\nY 30.10\nZ 29.90\n");

  ASSERT_THAT(imported.table.rows, SizeIs(3));
  EXPECT_NEAR(imported.table.rows[1].value_mm, 0.10, 1e-9);
  EXPECT_NEAR(imported.table.rows[2].value_mm, -0.10, 1e-9);
}

TEST(Sentences, SayNothingWithoutBothNumbers) {
  EXPECT_THAT(SentencesAsTable("I drew 40 mm and it looks odd.\n"), IsEmpty());
}

// A square of side a leaning by c: diagonals a sqrt(2) (1 -+ c/2).
TEST(Squares, DiagonalsBecomeLengthsAcrossThePlane) {
  const Imported imported = Read(
      "part,AC [mm],BD [mm],front edge [mm]\n1,141.2,141.6,100\n2,141.2,141.6,100\n");

  ASSERT_THAT(imported.table.rows, SizeIs(12));
  int num_diagonals = 0;
  for (const Row& row : imported.table.rows) {
    num_diagonals += std::abs(row.n[0] * row.n[1]) > 0.4 ? 1 : 0;
  }
  EXPECT_EQ(num_diagonals, 8);
}

constexpr const char* kMap = R"(<?xml version="1.0"?>
<heightmap MinX="10" MinY="0" MaxX="30" MaxY="50" SizeX="3" SizeY="2">
  <point X="0" Y="0">0.1</point>
  <point X="2" Y="1">-0.2</point>
  <point X="1" Y="0">NaN</point>
</heightmap>
)";

TEST(HeightmapXml, NodesStandWhereTheGridPutsThem) {
  const Imported imported = ImportText("xml-heightmap", kMap, "f", {});

  ASSERT_THAT(imported.table.rows, SizeIs(2));  // One was not probed.
  EXPECT_EQ(imported.table.rows[1].cmd_mm[0], 30);
  EXPECT_EQ(imported.table.rows[1].cmd_mm[1], 50);
  EXPECT_EQ(imported.table.rows[1].value_mm, -0.2);
}

TEST(HeightmapXml, APointOutsideItsGridIsRefused) {
  std::string text = kMap;
  text.replace(text.find("X=\"2\""), 5, "X=\"3\"");
  EXPECT_THAT([&] { ImportText("xml-heightmap", text, "f", {}); },
              ThrowsMessage<InputError>(HasSubstr("f:")));
}

TEST(PlainTable, TwoInstrumentsBesideEachOtherAreTwoCampaigns) {
  const Imported imported = ImportText(
      "table",
      "commanded_x,dial,laser\n0,0.000,0.000\n50,50.012,50.003\n100,100.021,100.004\n",
      "f.csv",
      {});

  EXPECT_EQ(imported.header.campaigns.at("dial").instrument, "dial");
  EXPECT_EQ(imported.header.instruments.at("laser").kind, "laser");
  EXPECT_EQ(imported.table.rows.front().campaign, "dial");
  EXPECT_EQ(imported.table.rows.back().campaign, "laser");
}

}  // namespace
}  // namespace caltwin

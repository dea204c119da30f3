#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/measure/import/console_line.h"
#include "sim/measure/import/import.h"
#include "sim/measure/import/recognise.h"

namespace caltwin {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

Imported Read(const std::string& text) {
  return ImportText("console-log", text, "f", {});
}

TEST(ConsoleLine, LosesWhatHostsAndTerminalsWriteBeforeIt) {
  for (const char* line : {"Recv: probe at 1,2 is z=3",
                           "SENT: probe at 1,2 is z=3",
                           "2026-11-22 10:00:00,120 - Recv: probe at 1,2 is z=3",
                           "19:42:07.197 : probe at 1,2 is z=3",
                           "5.11.2019, 19:31:24 | probe at 1,2 is z=3",
                           "[20:14:09] // probe at 1,2 is z=3",
                           "9:36:22 PM probe at 1,2 is z=3",
                           "- // probe at 1,2 is z=3",
                           "N12 probe at 1,2 is z=3*77"}) {
    EXPECT_EQ(ConsoleLineOf(line).text, "probe at 1,2 is z=3") << line;
  }
  EXPECT_EQ(ConsoleLineOf("9:36:22 PM x").t_s, (21 * 60 + 36) * 60 + 22);
  EXPECT_EQ(ConsoleLineOf("19:42:07.5 : x").t_s, (19 * 60 + 42) * 60 + 7.5);
  EXPECT_EQ(ConsoleLineOf("1 of 5: z: 0.043").text, "1 of 5: z: 0.043");
}

TEST(ConsoleLog, HomingAndLevellingBeginASession) {
  const Imported imported = Read(
      "G28\nprobe at 1,2 is z=0.1\nZ_TILT_ADJUST\nprobe at 1,2 is z=0.2\n"
      "Making the following Z adjustments:\nstepper_z = 0.1\nstepper_z1 = -0.1\n"
      "probe at 1,2 is z=0.3\n");

  ASSERT_THAT(imported.table.rows, SizeIs(3));
  EXPECT_EQ(imported.table.rows[0].home, "1");
  EXPECT_EQ(imported.table.rows[1].home, "2");
  EXPECT_EQ(imported.table.rows[2].home, "3");
  ASSERT_THAT(imported.levelling.rounds, SizeIs(1));
  EXPECT_THAT(imported.levelling.rounds[0].moved_mm, ElementsAre(0.1, -0.1));
  EXPECT_EQ(imported.levelling.rounds[0].home, "3");
}

TEST(ConsoleLog, TemperaturesAndToolsStandBesideTheTouchesThatFollow) {
  const Imported imported = Read(
      "T:210.5 /210.0 B:60.1 /60.0\nprobe at 1,2 is z=0.1\nT1\nprobe at 1,2 is "
      "z=0.2\n");

  ASSERT_THAT(imported.table.rows, SizeIs(2));
  EXPECT_EQ(imported.table.rows[0].temp_bed_c, 60.1);
  EXPECT_EQ(imported.table.rows[0].temp_nozzle_c, 210.5);
  EXPECT_EQ(imported.table.rows[1].setup, "bed_t1");
}

TEST(ConsoleLog, ALogWhoseNewestLineIsFirstIsReadFromItsEnd) {
  const Imported imported = Read(
      "10:00:09 probe at 1,2 is z=4\n10:00:07 probe at 1,2 is z=3\n"
      "10:00:05 probe at 1,2 is z=1\n10:00:03 probe at 1,2 is z=2\n");

  ASSERT_THAT(imported.table.rows, SizeIs(4));
  EXPECT_EQ(imported.table.rows[0].value_mm, 2);
  EXPECT_EQ(imported.table.rows[3].t_s, 6);
}

TEST(ConsoleLog, GrblsTouchesAreAlongTheAxisThatProbed) {
  const Imported imported = Read(
      "G91 G38.2 X-10 F120\n[PRB:-3.000,5.000,-1.000:1]\nG38.2 X-10 F120\n"
      "[PRB:-3.010,5.000,-1.000:1]\n[PRB:0,0,0:0]\nG38.2 Z-5 F60\n"
      "[PRB:0.000,5.000,-4.500:1]\n");

  ASSERT_THAT(imported.table.rows, SizeIs(3));
  const Row& second = imported.table.rows[1];
  EXPECT_EQ(second.n[0], 1);  // Moved to -, so the face looks to +.
  EXPECT_EQ(second.dir[0], -1);
  EXPECT_NEAR(second.value_mm, -0.010, 1e-12);
  EXPECT_EQ(second.feed_mm_s, 2);
  EXPECT_EQ(imported.table.rows[2].n[2], 1);
  EXPECT_EQ(imported.table.rows[2].value_mm, -4.5);
  EXPECT_THAT(imported.warnings, ElementsAre(HasSubstr("found nothing")));
}

TEST(ConsoleLog, AMeshWithCornersHasPlacesAndWithoutThemIndices) {
  const Imported with = Read(
      "Bed Topography Report:\n    ( 10,210)    (110,210)\n        0       1\n"
      " 1 | +0.100 [-0.200]\n   |\n 0 |   .    +0.300\n        0       1\n"
      "    ( 10, 10)    (110, 10)\n");
  ASSERT_THAT(with.table.rows, SizeIs(3));
  EXPECT_TRUE(with.has_places);
  EXPECT_EQ(with.table.rows[1].cmd_mm[0], 110);
  EXPECT_EQ(with.table.rows[1].cmd_mm[1], 210);
  EXPECT_EQ(with.table.rows[1].value_mm, -0.2);
  EXPECT_EQ(with.table.rows[2].cmd_mm[1], 10);

  const Imported without = Read(
      "Bilinear Leveling Grid:\n      0      1\n 0 +0.01 +0.02\n 1 +0.03 +0.04\nok\n");
  ASSERT_THAT(without.table.rows, SizeIs(4));
  EXPECT_FALSE(without.has_places);
  EXPECT_EQ(without.table.rows[3].value_mm, 0.04);
}

TEST(ConsoleLog, KlippersTwoTextsAreKeptApart) {
  const Imported imported =
      Read("probe at 1,2 is z=2.08\nprobe: at 1,27 bed will contact at z=0.0025\n");

  ASSERT_THAT(imported.table.rows, SizeIs(2));
  EXPECT_EQ(imported.table.rows[0].setup, "bed");
  EXPECT_EQ(imported.table.rows[1].setup, "bed_nominal");
  EXPECT_EQ(imported.table.rows[1].value_mm, 0.0025);
  ASSERT_THAT(imported.notes, SizeIs(1));
  EXPECT_EQ(imported.notes[0].what, "firmware");
}

TEST(ConsoleLog, RepRapFirmwaresHeightsAreOfThePointsThatG30Named) {
  const Imported imported = Read(
      "G30 P0 X15 Y20 Z-99999\nG30 P1 X200 Y20 Z-99999 S2\n"
      "G32 bed probe heights: 0.133 -0.045, mean 0.044, deviation from mean 0.089\n");

  ASSERT_THAT(imported.table.rows, SizeIs(2));
  EXPECT_EQ(imported.table.rows[1].cmd_mm[0], 200);
  EXPECT_EQ(imported.table.rows[1].value_mm, -0.045);
}

TEST(Recognise, FilesByWhatStandsInThem) {
  EXPECT_EQ(KindOfText("campaign,cmd_x_mm,value_mm\n", "a.csv"), "rows");
  EXPECT_EQ(KindOfText("// probe at 1,2 is z=3\n", "a.log"), "console-log");
  EXPECT_EQ(KindOfText("[PRB:0,0,1:1]\n", "a.txt"), "console-log");
  EXPECT_EQ(KindOfText("#*# [bed_mesh default]\n", "printer.cfg"), "klipper-mesh");
  EXPECT_EQ(KindOfText("RepRapFirmware height map file v2\n", "h.csv"),
            "rrf-heightmap");
  EXPECT_EQ(KindOfText("0 0.001 0\n", "x.comp"), "screw-table");
  EXPECT_EQ(KindOfText("#define XY_DIAG_AC 141.1\n", "C.h"), "marlin-config");
  EXPECT_EQ(KindOfText("[stepper_a]\n", "printer.cfg"), "printer-cfg");
  EXPECT_EQ(KindOfText("commanded,measured\n1,2\n", "a.csv"), "table");
}

}  // namespace
}  // namespace caltwin

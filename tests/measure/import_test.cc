#include "sim/measure/import/import.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/measure/import/fields.h"
#include "sim/measure/import/map.h"
#include "sim/measure/import/spreadsheet.h"
#include "tests/measure/import_bench.h"

namespace caltwin {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::StrEq;

TEST(Import, AnUnknownKindIsRefusedWithTheNearest) {
  EXPECT_THAT(ImportFault("iso230", "x"),
              AllOf(HasSubstr("the kind 'iso230' is not known"),
                    HasSubstr("It may be: iso230-dat, klipper-thermal, cmm-plate")));
  EXPECT_THAT(ImportFault("cmm-plates", "x"), HasSubstr("did you mean 'cmm-plate'?"));
}

TEST(Import, EveryKindRefusesNothingAtAllWithAMessage) {
  for (const Importer& importer : AllImporters()) {
    for (const char* text :
         {"", "\n", "hello\n", "1 2\n", "a,b\n", "{}\n", "{\n", ",\n"}) {
      EXPECT_THAT(ImportFault(std::string(importer.kind), text),
                  ::testing::Not(IsEmpty()))
          << importer.kind << ": " << text;
    }
  }
}

// What firmware swallowed, each in a line of its own (data/blunders of real issues).
TEST(Import, KnownBlundersAreToldWhateverTheKind) {
  const std::pair<const char*, const char*> blunders[] = {
      {"DELTA_ANALYZE CENTER_DISTS=74.7,74.1\nDELTA_ANALYZE WIDTHS=74.7,74.1\n",
       "f:2:1: WIDTHS repeats the list of CENTER_DISTS"},
      {"z = 0.145000 0.302500 0.452500 0.692500 0.927500\n",
       "f:1:1: the reported height climbs with every touch, by 0.782 mm in 5 touches"},
      {"stepper_z = -18353420.733733\n",
       "f:1:1: stepper_z is to be moved by -18353421 mm"},
      {"#*# [delta_calibrate]\n#*# height0 = -15.9\n",
       "f:2:1: height0 = -15.9 mm: the probe would trigger below the bed"},
      {"G33 reports std dev:-2147483.750 for Height:336.40\n",
       "f:1:1: a standard deviation of -2.14748e+06 mm"}};

  for (const auto& [text, message] : blunders) {
    for (const Importer& importer : AllImporters()) {
      EXPECT_THAT(ImportFault(std::string(importer.kind), text), HasSubstr(message));
    }
  }
}

TEST(Import, SoundRelativesOfTheBlundersPass) {
  const std::string sound =
      "DELTA_ANALYZE CENTER_DISTS=74.7,74.1\nDELTA_ANALYZE CENTER_DISTS=74.7,74.1\n"
      "stepper_z = 0.182622\n#*# height0 = -0.2\nstd dev:0.02\n"
      "z = 0.01 0.02 0.03 0.04 0.05\n";
  EXPECT_THAT(ImportFault("probe-accuracy", sound), HasSubstr("no touches and no"));
}

TEST(ImportProbeAccuracy, BatchesOfKlipperAndMarlin) {
  const RowTable table =
      RowsOf("probe-accuracy",
             "PROBE_ACCURACY at X:97.000 Y:2.000 Z:3.3 (samples=2 speed=10.0 lift=1)\n"
             "16:08:38 probe at 97.000,2.000 is z=1.320000\n"
             "// probe at 97.000,2.000 is z=1.317500\n"
             "M48 P20 X24 Y25\n1 of 2: z: 0.011\n2 of 2   z: 0.012 Mean: 0.0115\n");

  ASSERT_THAT(table.rows, SizeIs(4));
  EXPECT_EQ(table.rows[0].value_mm, 1.32);
  EXPECT_EQ(table.rows[0].feed_mm_s, 10);
  EXPECT_EQ(table.rows[0].t_s, 0);
  EXPECT_EQ(table.rows[1].rep, 2);
  EXPECT_EQ(table.rows[2].campaign, "m48");
  EXPECT_EQ(table.rows[2].cmd_mm[0], 24);
  EXPECT_EQ(table.rows[3].value_mm, 0.012);
}

// It is one place all the same, and a banner is no command.
TEST(ImportProbeAccuracy, ATouchWithoutPlaceIsOfOnePlace) {
  const RowTable table = RowsOf("probe-accuracy",
                                "Send: M48 P2 V2\nM48 Z-Probe Repeatability Test\n"
                                "Recv: 1 of 2: z: 0.011\nRECV: 2 OF 2: Z: 0.013\n");

  ASSERT_THAT(table.rows, SizeIs(2));
  EXPECT_FALSE(Known(table.rows[0].cmd_mm[0]));
  EXPECT_EQ(table.rows[0].cmd_mm[2], 0);
  EXPECT_EQ(table.rows[1].value_mm, 0.013);
  EXPECT_EQ(table.rows[1].campaign, "m48");
}

TEST(ImportProbeAccuracy, AHeightThatRunsAwayIsRefused) {
  std::string text;
  for (const char* z : {"0.145", "0.302", "0.452", "0.692", "0.927"}) {
    text += std::string("probe at 69.5,119.5 is z=") + z + "\n";
  }
  EXPECT_THAT(
      ImportFault("probe-accuracy", text),
      HasSubstr("f:1:1: the reported height climbs with every touch, by 0.782 mm "
                "in 5 touches of one place\n  the nozzle was at one place"));
}

constexpr const char* kMarlinLog =
    "2026-11-22 10:00:00,120 - Send: N1 G28*18\n"
    "2026-11-22 10:00:20,500 - Recv: echo:  M92 X80.00 Y80.00 Z400.00 E93.00\n"
    "2026-11-22 10:00:21,000 - Send: N2 G29 V4*33\n"
    "2026-11-22 10:00:25,000 - Recv: Bed X: 30.000 Y: 30.000 Z: 0.059\n"
    "2026-11-22 10:00:29,000 - Recv: Bed X: 190.000 Y: 30.000 Z: -0.041\n"
    "Recv: Bilinear Leveling Grid:\n"
    ">>> G28\n>>> G30 X50 Y60\nBed X: 50.00 Y: 60.00 Z: 0.03\n"
    ">>> M48 P2 X24 Y25\n1 of 2: z: 0.011\n2 of 2   z: 0.012 Mean: 0.0115\n"
    ">>> G30 X70 Y60\nBed X: 70.00 Y: 60.00 Z: 0.04\n";

TEST(ImportMarlinLog, TouchesOfEveryKind) {
  const RowTable table = RowsOf("marlin-log", kMarlinLog);

  ASSERT_THAT(table.rows, SizeIs(6));
  std::vector<std::string> campaigns;
  for (const Row& row : table.rows) campaigns.push_back(row.campaign + row.home);
  EXPECT_THAT(campaigns,
              ::testing::ElementsAre("g291", "g291", "g302", "m482", "m482", "g302"));
  EXPECT_EQ(table.rows[1].cmd_mm[0], 190);
  EXPECT_EQ(table.rows[1].value_mm, -0.041);
  EXPECT_EQ(table.rows[1].t_s, 4);
  EXPECT_EQ(table.rows[3].cmd_mm[1], 25);
  EXPECT_EQ(table.rows[4].value_mm, 0.012);
  EXPECT_EQ(table.rows[5].settings, "m503");
}

// An M48 without X and Y stands where the last move went; found by the fuzzer: without
// any, its rows had no place and were not read again.
TEST(ImportMarlinLog, M48TouchesWhereTheLastMoveWent) {
  const RowTable table = RowsOf("marlin-log",
                                "G28\nG1 X30 Y40 F3000\nG91\nG0 X-10\nG90\n"
                                "M48\n1 of 2: z: 0.011\n2 of 2: z: 0.012\n");
  ASSERT_THAT(table.rows, SizeIs(2));
  EXPECT_EQ(table.rows[1].cmd_mm[0], 20);
  EXPECT_EQ(table.rows[1].cmd_mm[1], 40);
}

TEST(ImportMarlinLog, ADeltaMakesAMachineFile) {
  const Imported imported =
      ImportText("marlin-log",
                 "echo:  M92 X80.00 Y80.00 Z80.00\n"
                 "echo:  M665 L250.00 R124.00 H300.00 S80 X0.1 Y0 Z0 A0.2 B0 C0\n"
                 "echo:  M666 X-0.10 Y0.00 Z-0.20\n",
                 "f",
                 {});

  EXPECT_THAT(imported.table.rows, SizeIs(0));
  EXPECT_THAT(imported.machine_yaml, HasSubstr("300.1"));
  EXPECT_THAT(imported.machine_yaml, HasSubstr("300.2"));
  EXPECT_THAT(imported.machine_yaml, HasSubstr("250.2"));
  EXPECT_THAT(imported.machine_yaml, HasSubstr("210.1"));
}

TEST(ImportMarlinLog, WhatIsNotReadIsRefused) {
  EXPECT_THAT(ImportFault("marlin-log", "ok\n"),
              HasSubstr("no touches and no settings"));
  EXPECT_THAT(ImportFault("marlin-log", "Bilinear Leveling Grid:\n 0 +0.07\n"),
              HasSubstr("f:1:1: a levelling grid does not say where"));
  EXPECT_THAT(ImportFault("marlin-log", "Bed X: 1 Y: z Z: 3\n"),
              HasSubstr("its numbers are not all there"));
  EXPECT_THAT(ImportFault("marlin-log", "M665 L100 R124 H300\n"),
              HasSubstr("a rod is longer than the delta radius"));
  EXPECT_THAT(ImportFault("marlin-log", "M92 Xnan\n"),
              HasSubstr("M92 Xnan is no number"));
}

TEST(ImportCmmPlate, HolesBecomeTwoRowsEach) {
  const RowTable table =
      RowsOf("cmm-plate", TestData("imports/plate_1396A_excerpt.txt"));

  ASSERT_THAT(table.rows, SizeIs(60));
  EXPECT_EQ(table.rows[0].campaign, "cmm_1396A");
  EXPECT_EQ(table.rows[0].cmd_mm[0], 82.326);
  EXPECT_NEAR(table.rows[0].value_mm, -0.020, 1e-9);
  EXPECT_THAT(table.rows[1].n, ::testing::ElementsAre(0, 1, 0));
  EXPECT_NEAR(table.rows[1].value_mm, 0.015, 1e-9);
  EXPECT_THAT(table.extra_columns,
              ::testing::ElementsAre("cmm_measd", "cmm_nomd", "cmm_round"));
}

TEST(ImportCmmPlate, AReversedSignAndAMixedUnitAreRefused) {
  const std::string heading = "Meas X Meas Y Nom X Nom Y Err X Err Y\n";

  EXPECT_THAT(ImportFault("cmm-plate", heading + "1.1 2.2 1.0 2.0 -0.1 -0.2\n"),
              HasSubstr("its sign is reversed"));
  EXPECT_THAT(ImportFault("cmm-plate", heading + "1.1 2.2 1.0 2.0 100 200\n"),
              HasSubstr("Err is not Meas - Nom in 2 of 2 places"));
  EXPECT_THAT(ImportFault("cmm-plate", heading + "1.1 2.2 1.0 x 0.1 0.2\n"),
              HasSubstr("f:2:13: nomy = 'x' is not a finite number"));
  EXPECT_THAT(ImportFault("cmm-plate", heading + "1.1 2.2\n"),
              HasSubstr("f:2:1: 2 words, where the heading names 6 columns"));
}

std::string MapFault(const std::string& map, const std::string& text) {
  return ImportFault("csv", text, {.map = {map}});
}

TEST(ImportMap, ColumnsByHeadingAndNumberWithUnitsAndConstants) {
  const RowTable table = RowsOf(
      "csv",
      "Soll\tIst\tZeit\tT\n0\t0,001\t23:59:58\t68\n10\t10,002\t00:00:02\t86\n"
      "10\t10,004\t00:00:04\t86\n0\t0,003\t00:00:08\t86\n",
      {.map = {"cmd_y_mm=Soll, actual_mm=2[mm]",
               "t_s=Zeit[clock],temp_frame_c=T[F],campaign:=laser,dir_y:=order"}});

  ASSERT_THAT(table.rows, SizeIs(4));
  EXPECT_NEAR(table.rows[1].value_mm, 0.002, 1e-12);
  EXPECT_EQ(table.rows[1].t_s, 4);  // Over midnight.
  EXPECT_NEAR(table.rows[0].temp_frame_c, 20, 1e-12);
  EXPECT_EQ(table.rows[0].campaign, "laser");
  EXPECT_EQ(table.rows[1].dir[1], 1);
  EXPECT_EQ(table.rows[2].dir[1], -1);  // Turned beyond 10, came back.
  EXPECT_EQ(table.rows[3].dir[1], -1);
}

TEST(ImportMap, InchesAndTheReversedSign) {
  const RowTable table =
      RowsOf("csv", "1 0.5\n2 -0.5\n", {.map = {"cmd_x_mm=1[inch],value_mm=-2[thou]"}});

  EXPECT_DOUBLE_EQ(table.rows[1].cmd_mm[0], 50.8);
  EXPECT_DOUBLE_EQ(table.rows[0].value_mm, -0.0127);
}

// Of feeds, loads and angles too: a feed of G-code is sixty times that of a row.
TEST(ImportMap, EveryColumnIsConvertedOrRefused) {
  const auto row_of = [](const std::string& map) {
    const std::string base = "cmd_x_mm=1[mm],value_mm=2[um],";
    return RowsOf("csv", "1 0.5 60\n2 0.5 120\n", {.map = {base + map}}).rows[1];
  };
  EXPECT_NEAR(row_of("feed_mm_s=3[mm/min]").feed_mm_s, 2, 1e-12);
  EXPECT_NEAR(row_of("feed_mm_s=3[ipm]").feed_mm_s, 50.8, 1e-12);
  EXPECT_NEAR(row_of("feed_mm_s=3[m/min]").feed_mm_s, 2000, 1e-9);
  EXPECT_EQ(row_of("feed_mm_s=3").feed_mm_s, 120);
  const RowTable from_nought =
      RowsOf("csv", "1 5 0\n2 5 1\n", {.map = {"cmd_x_mm=1,value_mm=2[um],rep=3"}});
  EXPECT_EQ(from_nought.rows[0].rep, 0);
  EXPECT_NEAR(row_of("load_n=3[lbf]").load_n, 533.7866, 1e-4);
  EXPECT_NEAR(row_of("load_n=3[kg]").load_n, 1176.798, 1e-9);
  EXPECT_NEAR(row_of("probe_angle_deg=1[rad]").probe_angle_deg, 114.591559, 1e-6);
  const std::string text = "pos [mm],F [mm/min],dev_um\n1,60,3\n3,120,4\n";
  const RowTable table =
      RowsOf("csv", text, {.map = {"cmd_x_mm=pos,feed_mm_s=F,value_mm=dev_um"}});
  EXPECT_EQ(table.rows[1].feed_mm_s, 2);
  EXPECT_THAT(
      MapFault("cmd_x_mm=1,value_mm=3[um],feed_mm_s=2[banana]", text),
      HasSubstr("the unit 'banana' is not known here\n  it may be: mm/s, mm/min"));
  EXPECT_THAT(MapFault("cmd_x_mm=1,value_mm=3[um],rep=2[mm]", text),
              HasSubstr("'mm' stands behind its source, and it has no unit\n  rep=2"));
}

TEST(ImportMap, WithoutAMapTheColumnsAreListed) {
  EXPECT_THAT(
      ImportFault("csv", "pos,dev\n1,2\n3,4\n"),
      HasSubstr("f: which column is which? Found: 1 'pos', 2 'dev'\n  as --map"));
}

TEST(ImportMap, FaultsSayWhatIsAllowed) {
  const std::string text = "pos,dev,n_um\n1,2,3\n3,x,4\n";

  EXPECT_THAT(MapFault("cmd_x_mm=pos,value_mm=dev", text),
              HasSubstr("nothing says its unit\n  say it: value_mm=dev[um]"));
  EXPECT_THAT(MapFault("cmd_x_mm=pos,value_mm=dve[um]", text),
              HasSubstr("f has no column 'dve'\n  did you mean 'dev'? It has 1 to 3"));
  EXPECT_THAT(MapFault("cmd_x_mm=pos,value_mm=n_um[mm]", text),
              HasSubstr("f:1:9: the heading says um, the map mm"));
  EXPECT_THAT(
      MapFault("cmd_x_mm=pos,value_mm=dev[um]", text),
      StrEq("f:3:3: value_mm = 'x' is not a finite number\n  an unknown value is "
            "an empty field"));
  EXPECT_THAT(MapFault("cmd_q_mm=pos", text),
              HasSubstr("'cmd_q_mm' is no column of measured rows\n  did you mean"));
  EXPECT_THAT(MapFault("value_mm=dev[um]", text),
              HasSubstr("does not say which column is the commanded position"));
  EXPECT_THAT(MapFault("cmd_x_mm=1,cmd_y_mm=2,value_mm=3", text),
              HasSubstr("along which the value is measured"));
  EXPECT_THAT(MapFault("cmd_x_mm=1,cmd_x_mm=2", text),
              HasSubstr("cmd_x_mm is assigned twice"));
  EXPECT_THAT(MapFault("cmd_x_mm", text), HasSubstr("this assigns nothing"));
}

TEST(ImportMap, TwoDecimalMarksAreAskedAbout) {
  EXPECT_THAT(MapFault("cmd_x_mm=1,value_mm=2[um]", "1.000,5;2\n3;4,5\n"),
              HasSubstr("f:1:1: '1.000,5' has a comma in it"));
}

TEST(Fields, TimesStepsAndNumbers) {
  EXPECT_EQ(ClockTime_s("2021/06/13-20:05:09").value() -
                ClockTime_s("2021-06-12 20:05:00").value(),
            86409);
  EXPECT_FALSE(ClockTime_s("2021/02/30-00:00:00"));
  EXPECT_FALSE(ClockTime_s("25:00:00"));
  EXPECT_FALSE(ClockTime_s(""));
  EXPECT_NEAR(StepOf({0.1, 0.1025, 0.11, 0.1075}), 0.0025, 1e-12);
  EXPECT_EQ(StepOf({0.1, 0.1031, 0.11, 0.1075}), 0);
  EXPECT_EQ(NumberOf("1,5", ','), 1.5);
  EXPECT_FALSE(NumberOf("1e999"));
  EXPECT_FALSE(NumberOf("inf"));
}

}  // namespace
}  // namespace caltwin

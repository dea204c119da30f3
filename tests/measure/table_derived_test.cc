// Columns that are reckoned, one sense against the other, readings that count steps,
// switches and pulses, as people write them down.

#include "sim/measure/import/table_derived.h"

#include <algorithm>
#include <string>
#include <tuple>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/measure/import/import.h"
#include "sim/measure/import/text_table.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;

Imported Read(const std::string& kind, const std::string& text) {
  return ImportText(kind, text, "f", {});
}

const FileNote* NoteOf(const Imported& imported, const std::string& what) {
  const auto found = std::ranges::find(imported.notes, what, &FileNote::what);
  return found == imported.notes.end() ? nullptr : &*found;
}

TEST(DropDerived, AColumnLessANumberSaysWhatTheOtherShouldBe) {
  const Imported imported = Read("table",
                                 "distances between the pillars\n"
                                 " A | B | A-74 | B-74\n"
                                 "73.93 | 73.63 | -0.07 | -0.37\n"
                                 "74.15 | 73.83 | 0.15 | -0.17\n"
                                 "73.95 | 73.72 | -0.05 | -0.28\n");

  ASSERT_THAT(imported.table.rows, SizeIs(6));
  for (const Row& row : imported.table.rows) {
    EXPECT_EQ(row.cmd_mm[0], 74);
    EXPECT_EQ(row.flag, "distance");
  }
  EXPECT_NEAR(imported.table.rows[0].value_mm, -0.07, 1e-9);
  EXPECT_NE(imported.table.rows[0].campaign, imported.table.rows[3].campaign);
}

TEST(DropDerived, AColumnThatIsNotWhatItSaysStays) {
  const Imported imported =
      Read("table", "A,A-74\n73.9,0.5\n74.1,0.9\n74.2,-0.5\n74.0,0.3\n");

  for (const Row& row : imported.table.rows) EXPECT_NE(row.flag, "distance");
  EXPECT_THAT(imported.assumed, testing::Not(testing::Contains(HasSubstr("reckoned"))));
}

// v = 0 - read at the minus sense: lost motion of the mean.
TEST(PartSenses, TheOneSenseIsReadAndTheOtherIsNought) {
  const Imported imported =
      Read("table", "speed (mm/min),even rows vs odd rows (mm)\n600,0.14\n6000,0.13\n");

  ASSERT_THAT(imported.table.rows, SizeIs(4));
  EXPECT_EQ(imported.table.rows[0].dir[0], -1);
  EXPECT_NEAR(imported.table.rows[0].value_mm, 0.14, 1e-12);
  EXPECT_EQ(imported.table.rows[1].dir[0], 1);
  EXPECT_EQ(imported.table.rows[1].value_mm, 0);
  EXPECT_EQ(imported.table.rows[3].feed_mm_s, 100);
}

TEST(CountedStep, IsSaidByTheTextOrThereIsNone) {
  EXPECT_DOUBLE_EQ(CountedStep_mm("# correction in steps, 80 steps/mm"), 0.0125);
  EXPECT_DOUBLE_EQ(CountedStep_mm("in steps\n160.5 steps/mm"), 1 / 160.5);
  EXPECT_EQ(CountedStep_mm("80 steps/mm set, readings in mm"), 0);
  EXPECT_EQ(CountedStep_mm("in steps of a hundredth"), 0);
  EXPECT_EQ(CountedStep_mm("jogged in steps of 10 mm, 80 steps/mm set"), 0);

  const Imported imported =
      Read("table",
           "# each after G28, in steps, 80 steps/mm\n"
           "run,alpha,beta,gamma\n1,5,0,-2\n2,-1,0,-1\n3,1,0,1\n4,2,-1,2\n5,-2,1,-2\n6,"
           "0,0,4\n7,3,-1,-2\n8,2,0,1\n");
  ASSERT_THAT(imported.table.rows, SizeIs(24));
  EXPECT_NEAR(imported.table.rows[0].value_mm, 5 / 80.0, 1e-12);
  EXPECT_NE(imported.table.rows[0].home, imported.table.rows[1].home);
}

TEST(TableInText, AHeadingMayLeaveOutTheColumnOfAxes) {
  EXPECT_THAT(TableInText("      in the file    machined\n"
                          "x     30mm           150mm\n"
                          "y     10mm           50mm\n"),
              HasSubstr("axis\tin the file\tmachined\nx\t30mm\t150mm\n"));
}

TEST(Sentences, AMoveOfGCodeAndWhatWasMeasuredBelowIt) {
  const Imported imported = Read("table", "my notes\n\ng1x100\nmeasured: 51.66mm\n");

  ASSERT_THAT(imported.table.rows, SizeIs(1));
  EXPECT_EQ(imported.table.rows[0].cmd_mm[0], 100);
  EXPECT_NEAR(imported.table.rows[0].value_mm, -48.34, 1e-9);
}

// As the plugin prints it, the hint behind its calibration; both have the offset.
TEST(SwitchStory, ADistanceFixedInTheToolheadThatChangesIsSaid) {
  const std::string line =
      "Z-CALIBRATION: probe=6.74 - (switch={0} - nozzle={1} + switch_offset=0.300) --> "
      "new offset={2}\n"
      "HINT: z position_endstop={3} - offset={2} --> possible z position_endstop=2\n";
  const auto log = [&](const std::string& last_endstop) {
    std::string text;
    for (const auto& [body, nozzle, offset, endstop] :
         {std::tuple("8.071", "1.509", "-0.125644", "1.845"),
          std::tuple("7.665", "1.422", "0.216039", last_endstop.c_str())}) {
      text += fmt::format(fmt::runtime(line), body, nozzle, offset, endstop);
    }
    return Read("console-log", text);
  };

  const Imported raised = log("3.000");
  const FileNote* open = NoteOf(raised, "cause");
  ASSERT_NE(open, nullptr);
  EXPECT_NEAR(open->figures[0].value, 319, 1e-6);
  EXPECT_NE(NoteOf(raised, "position_endstop"), nullptr);
  ASSERT_THAT(raised.table.rows, SizeIs(6));
  EXPECT_EQ(raised.table.rows[0].settings, "endstop_1.845");
  EXPECT_EQ(raised.table.rows[1].settings, "endstop_3");

  const Imported repeated = log("1.845");
  EXPECT_EQ(NoteOf(repeated, "cause"), nullptr) << "repeats under one endstop";
  EXPECT_EQ(repeated.table.rows[0].settings, repeated.table.rows[1].settings);
}

TEST(PulseRate, WhatABoardOfEightBitsCannotSendIsSaid) {
  const FileNote* note = nullptr;
  const Imported asked =
      Read("console-log", "Grbl 1.1h ['$' for help]\n$100=640\n$110=10000\nok\n");
  note = NoteOf(asked, "pulse_rate");  // Allowed, and perhaps never asked for.
  ASSERT_NE(note, nullptr);
  EXPECT_EQ(note->kind, FileNote::Kind::kOpen);
  EXPECT_NEAR(note->figures[0].value, 640 * 10000 / 60e3, 1e-9);

  const Imported prose = Read(
      "console-log", "laser with grbl\n$100     640\n3500mm/m ok\n5000mm/m locks\n");
  note = NoteOf(prose, "settings");
  ASSERT_NE(note, nullptr);
  EXPECT_NEAR(note->figures[0].value, 640 * 5000 / 60e3, 1e-9);

  for (const char* right :
       {"Grbl 1.1h\n$100=160\n$110=10000\nG1 X1\n[PRB:1,1,1:1]\n",
        "GrblHAL 1.1f on ESP32\n$100=640\n$110=10000\n[PRB:1,1,1:1]\n"}) {
    EXPECT_EQ(NoteOf(Read("console-log", right), "settings"), nullptr) << right;
    EXPECT_EQ(NoteOf(Read("console-log", right), "pulse_rate"), nullptr) << right;
  }
}

TEST(GrblStory, MotorsThatAreOffInThePausesLetTheAxisDrift) {
  const auto log = [](const std::string& idle_ms) {
    return Read("console-log",
                "Grbl 0.9i\n$1=" + idle_ms +
                    " (step idle delay, msec)\n$100=80\n$101=80\nok\n"
                    "a G4 P0.3 at each lift\n"
                    "0 lifts: +0.0\n5 lifts: -1.9\n10 lifts: -4.1\n15 lifts: -6.0\n"
                    "20 lifts: -8.1\n");
  };

  EXPECT_NE(NoteOf(log("25"), "settings"), nullptr);
  EXPECT_EQ(NoteOf(log("255"), "settings"), nullptr);
}

TEST(PartSenses, BesideBothSensesADifferenceIsReckoned) {
  const Imported imported = Read("table",
                                 "pos,forward,backward,forward minus backward\n"
                                 "10,10.01,9.98,0.03\n20,20.02,19.99,0.03\n"
                                 "30,30.02,29.98,0.04\n");

  ASSERT_THAT(imported.table.rows, SizeIs(6));
  EXPECT_NEAR(imported.table.rows[0].value_mm, 0.01, 1e-9);
  EXPECT_EQ(imported.table.rows[3].dir[0], -1);
}

TEST(PlainTable, TolerancesAndNamesOfFilesAreNoReadings) {
  const Imported sheet = Read(
      "table",
      "Nominal,Measured,Plus tol,Minus tol\n50,50.02,0.1,-0.1\n60,60.01,0.1,-0.1\n");
  ASSERT_THAT(sheet.table.rows, SizeIs(2));
  EXPECT_NEAR(sheet.table.rows[0].value_mm, 0.02, 1e-9);
  EXPECT_FALSE(Known(sheet.table.rows[0].dir[0]));

  const Imported files =
      Read("table", "File,commanded,measured\ncube.stl,20,20.05\nbar.stl,80,80.1\n");
  ASSERT_THAT(files.table.rows, SizeIs(2));
  EXPECT_NEAR(files.table.rows[1].value_mm, 0.1, 1e-9);
}

}  // namespace
}  // namespace caltwin

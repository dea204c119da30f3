// Grids of heights without a word beside them, and what else is no table.

#include "sim/measure/import/bare_grid.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/input_error.h"
#include "sim/measure/import/import.h"
#include "sim/measure/import/recognise.h"

namespace caltwin {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr const char* kGrid =
    "-0.09\t-0.09\t-0.07\t0.02\n0.10\t0.05\t0\t0.04\n0.04\t0.03\t-0.03\t+0.06\n";

TEST(BareGrids, BeginWhereTheirFirstLineStands) {
  EXPECT_THAT(BareGrids(kGrid), ElementsAre(1));
  EXPECT_THAT(BareGrids(std::string("cold\n") + kGrid + "warm bed\n" + kGrid),
              ElementsAre(2, 6));
  EXPECT_THAT(BareGrids("0.1, 0.2, 0.3\n0.1, 0.2, 0.3\n0.2, 0.2, 0.3\n"),
              ElementsAre(1));
}

// As consoles print them: the columns' numbers above, the lines' in front.
TEST(BareGrids, MayBeNumbered) {
  const std::string text =
      "<-      0     1     2     3\n<- 0 -0.50 -0.24 -0.02 +0.12\n"
      "<- 1 -0.39 -0.20 -0.04 +0.10\n<- 2 -0.37 -0.17 +0.00 +0.13\n";
  EXPECT_THAT(BareGrids(text), ElementsAre(2));
  const Imported imported = ImportText("console-log", text, "f.txt", {});

  ASSERT_EQ(imported.table.rows.size(), 12U);
  EXPECT_DOUBLE_EQ(imported.table.rows[0].value_mm, -0.50);
  EXPECT_DOUBLE_EQ(imported.table.rows[11].value_mm, 0.13);
}

TEST(BareGrids, AreNoTablesOfPlaces) {
  // x, y and a height; told and read; counts; two columns; ten repeats of three places.
  EXPECT_THAT(BareGrids("10.0 10.0 0.1\n100.0 10.0 0.2\n190.0 100.0 0.1\n"), IsEmpty());
  EXPECT_THAT(BareGrids("1.0 1.01 1.02\n5.0 5.01 5.02\n9.0 9.01 9.02\n"), IsEmpty());
  EXPECT_THAT(BareGrids("1 2 3\n4 5 6\n7 8 9\n"), IsEmpty());
  EXPECT_THAT(BareGrids("0.1 0.2\n0.1 0.3\n0.2 0.2\n"), IsEmpty());
  std::string repeats;
  for (int i = 0; i < 10; ++i) repeats += "0.11 0.12 0.13\n";
  EXPECT_THAT(BareGrids(repeats), IsEmpty());
}

TEST(BareGrids, AreReadAsMeshesByIndex) {
  const std::string text = std::string("cold\n") + kGrid + "warm bed\n" + kGrid;
  ASSERT_EQ(KindOfText(text, "f.txt"), "console-log");
  const Imported imported = ImportText("console-log", text, "f.txt", {});

  ASSERT_EQ(imported.table.rows.size(), 24U);
  EXPECT_FALSE(imported.has_places);
  EXPECT_EQ(imported.table.rows[0].campaign, "mesh");
  EXPECT_EQ(imported.table.rows[12].campaign, "mesh_2");
  EXPECT_DOUBLE_EQ(imported.table.rows[13].value_mm, -0.09);
  // What is known for a grid is read as one, however its numbers are parted.
  const std::string parted = "0.1;0.2;0.3\n0.1;0.2;0.3\n0.2;0.2;0.3\n";
  EXPECT_EQ(ImportText(KindOfText(parted, "f"), parted, "f", {}).table.rows.size(), 9U);
}

TEST(Recognise, TellsModulesAndMacrosFromTables) {
  EXPECT_EQ(
      KindOfText("[z_tilt]\nz_positions:\n  20, 20\n  300, 20\nretries: 5\n", "f"),
      "printer-cfg");
  EXPECT_EQ(KindOfText("; bed.g\nM561\nG28 ; home\nG30 P0 X0 Y0 Z-9999\nG1 Z5\n", "f"),
            "rrf-config");
  EXPECT_EQ(
      KindOfText("if state.status != \"busy\"\n  M561\nwhile iterations < 3\n  G32\n"
                 "  if move.calibration.final.deviation < 0.02\n    break\n"
                 "echo \"done\"\n",
                 "f"),
      "rrf-config");
  EXPECT_EQ(KindOfText("Plate 8131\nFitScale 1.000007\n  NomX NomY MeasX MeasY ResidX\n"
                       "11.650 -10.184 11.610 -10.090 -0.002\n",
                       "f"),
            "cmm-plate");
  EXPECT_EQ(KindOfText("commanded,measured\n10,10.1\n20,20.2\n", "f"), "table");
}

std::string NoteOf(const std::string& text) {
  const Imported imported = ImportText("console-log", text, "f.txt", {});
  return imported.notes.empty() ? "" : imported.notes.front().sentence;
}

TEST(ConsoleStory, TellsWhetherG33SettledOrRanAway) {
  const auto iterations = [](const char* first, const char* second, const char* third) {
    return std::string("08:33:22.794 : Iteration : 01      std dev:") + first +
           "\n08:33:47.482 : Iteration : 02      std dev:" + second +
           "\n08:34:12.482 : Iteration : 03      std dev:" + third + "\n";
  };
  EXPECT_THAT(NoteOf(iterations("2.665", "0.128", "0.025")),
              HasSubstr("0.025 mm after 3 iterations, from 2.665"));
  EXPECT_THAT(NoteOf(iterations("0.665", "0.128", "1.025")), HasSubstr("runs away"));
}

TEST(ConsoleStory, TellsAScrewThatDoesNotFollow) {
  EXPECT_THAT(NoteOf("Z2-Z1=7.29 Z3-Z2=7.37 Z3-Z1=14.65\n"
                     "Z2-Z1=0.72 Z3-Z2=13.93 Z3-Z1=14.65\n"
                     "Z2-Z1=0.02 Z3-Z2=13.87 Z3-Z1=13.86\n"
                     "Z2-Z1=0.01 Z3-Z2=13.82 Z3-Z1=13.81\n"),
              HasSubstr("screw Z3 does not follow its correction"));
  EXPECT_THAT(NoteOf("Z2-Z1=0.01 Z3-Z2=7.37 Z3-Z1=7.36\n"
                     "Z2-Z1=1.00 Z3-Z2=1.30 Z3-Z1=0.30\n"
                     "Z2-Z1=0.02 Z3-Z2=0.03 Z3-Z1=0.01\nM92 X80 Y80 Z400\n"),
              "");
}

// "[...]" begins no section of a configuration.
TEST(ConsoleStory, PassesOverWhatSomebodyLeftOut) {
  const Imported imported = ImportText("console-log",
                                       "Recv: 1 of 3: z: 0.035\n[...]\n"
                                       "Recv: 2 of 3: z: 0.045\n[...]\n"
                                       "Recv: 3 of 3: z: 0.053\n",
                                       "f.txt",
                                       {});
  EXPECT_EQ(imported.table.rows.size(), 3U);
}

// Where nothing else is read, a blunder in the file is the answer.
TEST(Blunders, AnswerWhereNothingCanBeRead) {
  const std::string fit =
      "stepper_a: position_endstop: 130.8 angle: 300.2 arm_length: 1620.1\n"
      "stepper_b: position_endstop: 779.1 angle: 415.9 arm_length: 773.2\n"
      "stepper_c: position_endstop: 637.7 angle: 90.0 arm_length: 830.7\n";
  const Imported told =
      ImportText("console-log", fit, "f.txt", {.tells_blunders = true});
  ASSERT_EQ(told.notes.size(), 1U);
  EXPECT_THAT(told.notes[0].sentence, HasSubstr("fitted to be 773 to 1620 mm long"));
  const std::string alike =
      "stepper_a: arm: 269.3\nstepper_b: arm: 269.1\nstepper_c: arm: 268.5\n";
  EXPECT_THROW(ImportText("console-log", alike, "f.txt", {.tells_blunders = true}),
               InputError);
}

}  // namespace
}  // namespace caltwin

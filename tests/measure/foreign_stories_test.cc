// What short files of people say that are no plain tables: refused levellings, offsets
// written too early, maps of zeros, heights with names, paths of programs, turns.

#include <algorithm>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/input_error.h"
#include "sim/measure/import/drawn_path.h"
#include "sim/measure/import/import.h"
#include "sim/measure/import/rotary_table.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

Imported Read(const std::string& text) {
  return ImportText(KindOrFound("", text, "f"), text, "f", {});
}

const FileNote* NoteOf(const Imported& imported, const std::string& what) {
  const auto found = std::ranges::find(imported.notes, what, &FileNote::what);
  return found == imported.notes.end() ? nullptr : &*found;
}

double FigureOf(const FileNote& note, const std::string& key) {
  const auto found = std::ranges::find(note.figures, key, &NoteFigure::key);
  return found == note.figures.end() ? kUnknown : found->value;
}

TEST(CorrectionLimit, TellsTheMotorTheLimitAndTheTilt) {
  const Imported imported = Read(
      "G30 P0 X20 Y117 Z-9999\nG30 P1 X215 Y117 Z-9999 S2\nG32\n"
      "Error: Some computed corrections exceed configured limit of 1.00mm: -0.7 "
      "-1.5\n");
  const FileNote* note = NoteOf(imported, "settings");
  ASSERT_NE(note, nullptr);
  EXPECT_NEAR(FigureOf(*note, "limit_um"), 1000, 1e-9);
  EXPECT_NEAR(FigureOf(*note, "largest_um"), 1500, 1e-9);
  EXPECT_NEAR(FigureOf(*note, "tilt_um"), 800, 1e-9);
  EXPECT_THAT(note->sentence, HasSubstr("motor 2 by -1.500"));
  EXPECT_THAT(note->sentence, HasSubstr("over points 195 mm apart"));
}

TEST(CorrectionLimit, AsManyPointsAsMotorsProveNothing) {
  const std::string line =
      "Leadscrew adjustments made: 0.12 0.11, points used {}, (mean, deviation) before "
      "(0.1, 0.0) after (0.0, 0.0)\n";
  EXPECT_NE(NoteOf(Read(fmt::format(fmt::runtime(line), 2)), "levelling"), nullptr);
  const std::string touch = "Stopped at height 0.1 mm\nStopped at height 0.2 mm\n";
  EXPECT_EQ(NoteOf(Read(touch + fmt::format(fmt::runtime(line), 3)), "levelling"),
            nullptr);
}

std::string TinyG(double set_mm) {
  return fmt::format(
      "G38.2 Z-45 F20\nG10 L2 P1 Z{}\n"
      "{{\"r\":{{\"prb\":{{\"e\":1,\"x\":20.0,\"y\":10.0,\"z\":-38.91,\"a\":0.0}}}}}}"
      "\n",
      set_mm);
}

TEST(TouchOffset, TheTargetOfATouchIsNotWhereItTouched) {
  const Imported imported = Read(TinyG(-45));
  ASSERT_THAT(imported.table.rows, SizeIs(1));
  EXPECT_NEAR(imported.table.rows[0].value_mm, -38.91, 1e-12);
  EXPECT_EQ(imported.table.rows[0].cmd_mm[1], 10);
  const FileNote* note = NoteOf(imported, "work_offset");
  ASSERT_NE(note, nullptr);
  EXPECT_NEAR(FigureOf(*note, "change_um"), -6090, 1e-6);
  EXPECT_EQ(NoteOf(Read(TinyG(-38.91)), "work_offset"), nullptr);
}

TEST(TouchOffset, OfGrblToo) {
  const Imported imported =
      Read("G38.2 Z-20 F50\n[PRB:1.0,2.0,-12.5:1]\nG10 L2 P1 Z-20\n");
  ASSERT_NE(NoteOf(imported, "work_offset"), nullptr);
}

// The third field is Z, however many there are.
TEST(GrblTouch, OfSixAxes) {
  const Imported imported = Read(
      "G38.2 Z-1\n[PRB:10.0,20.0,-0.064,0.0,0.0,0.0:1]\n"
      "G38.2 Z-1\n[PRB:30.0,20.0,-0.1,0.0,0.0,0.0:0]\n");
  ASSERT_THAT(imported.table.rows, SizeIs(1));
  EXPECT_NEAR(imported.table.rows[0].value_mm, -0.064, 1e-12);
  EXPECT_THAT(imported.warnings, SizeIs(1));
}

TEST(CandleMap, IsReadAndOneOfZerosIsToldFor) {
  const std::string head = "0;0;30;20\n3;2;-1;1\n0;3;3\n";
  const Imported imported = Read(head + "0.1;0.2;0.3\n0.4;0.5;0.6\n");
  ASSERT_THAT(imported.table.rows, SizeIs(6));
  EXPECT_EQ(imported.table.rows[4].cmd_mm[0], 15);
  EXPECT_EQ(imported.table.rows[4].cmd_mm[1], 20);
  EXPECT_NEAR(imported.table.rows[4].value_mm, 0.5, 1e-12);
  EXPECT_THAT(imported.notes, IsEmpty());
  EXPECT_NE(NoteOf(Read(head + "0;0;0\n0;0;0\n"), "file"), nullptr);
}

TEST(CandleMap, BesideTouchesThatDifferItIsTheSenders) {
  const Imported imported = Read(
      "G38.2 Z-1\n[PRB:0.0,0.0,-0.1:1]\nG38.2 Z-1\n[PRB:30.0,0.0,0.1:1]\n"
      "--- board.map ---\n0;0;30;20\n2;2;-1;1\n0;2;2\n0;0\n0;0\n");
  const FileNote* note = NoteOf(imported, "file");
  ASSERT_NE(note, nullptr);
  EXPECT_THAT(note->sentence, HasSubstr("differ by 0.200 mm"));
}

TEST(NamedHeights, OfADeltaAndOfMarlinsNames) {
  for (const std::string names : {"ox oy oz", "yz zx xy"}) {
    const std::string text = fmt::format(
        "after three rounds\nc: 0.001\nx: 0.002\ny: -0.001\nz: 0.0\n{}: 0.1\n{}: "
        "-0.1\n{}: 0.02\n",
        names.substr(0, 2),
        names.substr(3, 2),
        names.substr(6, 2));
    const Imported imported = Read(text);
    ASSERT_THAT(imported.table.rows, SizeIs(7));
    EXPECT_FALSE(imported.has_places);
    EXPECT_EQ(imported.table.rows[4].feature, "delta.ox");
    EXPECT_NEAR(imported.table.rows[4].cmd_mm[1], 0.5, 1e-12);
  }
}

TEST(NamedHeights, OfCornersARunACampaign) {
  const Imported imported = Read(
      "before\nFrontR 0.065\nFrontL 0.342\nback right: 0.392\nBack left: 0.353\n"
      "after\nfr 0.182\nfl 0.3\nbr 0.61\nbl 0.47\n");
  ASSERT_THAT(imported.table.rows, SizeIs(8));
  EXPECT_EQ(imported.table.rows[0].campaign, "before");
  EXPECT_EQ(imported.table.rows[2].feature, "corner.back_right");
  EXPECT_EQ(imported.table.rows[7].campaign, "after");
  EXPECT_EQ(imported.table.rows[7].cmd_mm[0], 0);
}

TEST(NamedHeights, TemperaturesAndASweepBesideThemAreNone) {
  EXPECT_NE(KindOrFound("", "bed temperature\nFL 10.5\nFR 11\nBL 9\nBR 12\n", "f"),
            "named-heights");
  EXPECT_NE(KindOrFound("",
                        "commanded,measured\n10,10.1\n20,20.2\n30,30.3\n40,40.4\n"
                        "50,50.5\nFL 0.1\nFR 0.2\nBL 0.1\nBR 0.3\n",
                        "f"),
            "named-heights");
}

std::string Square(const std::string& size, double path_mm) {
  return fmt::format(
      "drawn {0}, tool 3 mm, inside\n"
      "G0 X0 Y0\nG1 X{1} Y0\nG1 X{1} Y{1}\nG1 X0 Y{1}\n",
      size,
      path_mm);
}

TEST(DrawnPath, AProgramOfTheWrongSizeIsNoFaultOfTheMachine) {
  // 10 * 96 / 90 less the tool.
  const auto note = NoteOfDrawnPath(Square("10mm x 10mm", 10 * 96.0 / 90 - 3));
  ASSERT_TRUE(note);
  EXPECT_EQ(note->what, "file");
  EXPECT_NEAR(FigureOf(*note, "factor"), 96.0 / 90, 1e-9);
  EXPECT_THAT(note->sentence, HasSubstr("pixels an inch"));
}

TEST(DrawnPath, ARightOneSaysToLookElsewhere) {
  const auto note = NoteOfDrawnPath(Square("10 x 10 mm", 7));
  ASSERT_TRUE(note);
  EXPECT_EQ(note->kind, FileNote::Kind::kOpen);
  EXPECT_FALSE(NoteOfDrawnPath("G1 X10 Y10\nG1 X0 Y10\nG1 X0 Y0\n"));
}

TEST(DrawnPath, RapidsAndParkingAreNoPathAndRelativeMovesAreNotAddedUp) {
  const std::string path = "G1 X7 Y0\nG1 X7 Y7\nG1 X0 Y7\nG1 X0 Y0\n";
  const auto note =
      NoteOfDrawnPath("drawn 10 x 10 mm, tool 3 mm, inside\n" + path + "G0 X0 Y150\n");
  ASSERT_TRUE(note);
  EXPECT_EQ(note->kind, FileNote::Kind::kOpen);
  EXPECT_FALSE(NoteOfDrawnPath("G91\ndrawn 10 x 10 mm, tool 3 mm, inside\n" + path));
  EXPECT_FALSE(NoteOfDrawnPath("drawn 10 x 10 mm, tool 3 mm, inside\n" + path +
                               "told  read\n10  10.1\n20  20.2\n30  30.3\n"));
}

std::string Turns(double deg_per_turn, double scatter_deg) {
  std::string text = "$103=53.333\n\n| turns | A in DRO | off (deg) |\n|---|---|---|\n";
  for (const int turns : {10, 100, 250, 500, 1000, 2000}) {
    const double off_deg =
        deg_per_turn * turns + (turns % 100 == 0 ? scatter_deg : -scatter_deg);
    text += fmt::format("| {} | {} | {:.4f} |\n", turns, 360 * turns, off_deg);
  }
  return text + "| 1000, back | 0 | -0.01 |\n";
}

TEST(RotaryTable, AnErrorThatGrowsWithTheTurnsIsARatio) {
  const auto note = NoteOfRotaryTable(Turns(-0.00225, 0.01));
  ASSERT_TRUE(note);
  EXPECT_NEAR(FigureOf(*note, "deg_per_turn"), -0.00225, 2e-5);
  EXPECT_NEAR(FigureOf(*note, "factor"), 1 - 0.00225 / 360, 1e-7);
  EXPECT_THAT(note->sentence, HasSubstr("rounding of the setting"));
}

TEST(RotaryTable, AConstantAndOtherColumnsOfALetterAreNone) {
  EXPECT_FALSE(NoteOfRotaryTable(
      "| turns | off (deg) |\n|---|---|\n| 10 | -0.50 |\n| 11 | -0.52 |\n"
      "| 12 | -0.49 |\n| 13 | -0.51 |\n| 14 | -0.50 |\n"));
  EXPECT_FALSE(NoteOfRotaryTable(
      "| A mm | tilt error (deg) |\n|---|---|\n| 1000 | 0.1 |\n| 2000 | 0.2 |\n"
      "| 3000 | 0.3 |\n| 4000 | 0.4 |\n"));
}

TEST(RotaryTable, ScatterIsNoneAndALargeErrorIsNoRounding) {
  EXPECT_FALSE(NoteOfRotaryTable(Turns(0, 0.5)));
  const auto large = NoteOfRotaryTable(Turns(-0.36, 0.01));
  ASSERT_TRUE(large);
  EXPECT_THAT(large->sentence, Not(HasSubstr("rounding of the setting")));
}

TEST(CornerSpeed, AJunctionOfMetresNeverSlows) {
  const std::string settings = "$110=1680.000 (x max rate)\n$120=0.100 (x accel)\n";
  const Imported imported =
      Read("$11=3000.000 (junction deviation, mm)\n$100=250.0\n" + settings);
  const FileNote* note = NoteOf(imported, "settings");
  ASSERT_NE(note, nullptr);
  // sqrt(0.1 * 3000 * 2.414) mm/s.
  EXPECT_THAT(note->sentence, HasSubstr("up to 1615 mm/min"));
  EXPECT_THROW(Read("$11=0.010\n$100=250.0\n" + settings), InputError);  // All right.
}

TEST(CornerSpeed, BeforeGrbl09TheNumberWasAnothers) {
  EXPECT_THROW(
      Read("$9=0.050 (junction deviation, mm)\n$11=25 (n-arc correction, int)\n"
           "$100=250.0\n"),
      InputError);
}

std::string Engine(double reported) {
  return fmt::format(
      "g2: --G--> N0G1X2.00000F360.0 [g2]\n"
      "g2: <-- {{\"sr\":{{\"posx\":2.000,\"vel\":0.00,\"stat\":3}}}}\n"
      "g2: --G--> N0G1A2.00000F360.0 [g2]\n"
      "g2: <-- {{\"sr\":{{\"posa\":{:.3f},\"vel\":0.00,\"stat\":3}}}}\n",
      reported);
}

TEST(ReportedMove, AFactorOfInchesIsTheControllersOwn) {
  const Imported imported = Read(Engine(2 / 25.4));
  const FileNote* note = NoteOf(imported, "firmware");
  ASSERT_NE(note, nullptr);
  EXPECT_EQ(note->axis, "a");
  EXPECT_THAT(note->sentence, HasSubstr("X went where it was told"));
  EXPECT_THROW(Read(Engine(2)), InputError);  // Nothing to be told.
  EXPECT_THROW(Read("G20\n" + Engine(2 / 25.4)), InputError);
  std::string alike = Engine(2 / 25.4);
  alike.replace(alike.find("2.000,"), 6, "0.079,");
  EXPECT_THROW(Read(alike), InputError);
}

std::string Mesh(double height_mm) {
  std::string text = "others < Bilinear Leveling Grid:\nothers <    0 1 2\n";
  for (int row = 0; row < 3; ++row) {
    text += fmt::format("others < {} {:+.3f} {:+.3f} {:+.3f}\n",
                        row,
                        height_mm + 0.01 * row,
                        height_mm - 0.02,
                        height_mm + 0.03);
  }
  return text;
}

TEST(StepsBetween, TwoMapsAndAnM92BetweenThem) {
  const Imported imported = Read(Mesh(7) + "M92 Z400\nM92 X80 Z392\n" + Mesh(1.4));
  ASSERT_THAT(imported.table.rows, SizeIs(18));
  const FileNote* note = NoteOf(imported, "settings");
  ASSERT_NE(note, nullptr);
  EXPECT_NEAR(FigureOf(*note, "change_um"), -5600, 1);
  EXPECT_THAT(note->sentence, HasSubstr("-2.00 %, over 280 mm of travel"));
  EXPECT_EQ(NoteOf(Read(Mesh(7) + Mesh(1.4)), "settings"), nullptr);
  const std::string report = "echo:  M92 X80.00 Y80.00 Z400.00\n";
  EXPECT_EQ(NoteOf(Read(report + Mesh(7) + report + Mesh(6.6)), "settings"), nullptr);
}

std::string Printer(double endstop_mm, double offset_mm) {
  return fmt::format(
      "[stepper_z]\nendstop_pin: probe:z_virtual_endstop\n"
      "position_endstop: {}\n[probe]\npin: PC4\nz_offset: {}\n",
      endstop_mm,
      offset_mm);
}

TEST(PrinterLint, WithTheProbeAsSwitchBothHeightsAreOne) {
  const Imported imported = Read(Printer(0, 2.41));
  const FileNote* note = NoteOf(imported, "position_endstop");
  ASSERT_NE(note, nullptr);
  EXPECT_NEAR(FigureOf(*note, "change_um"), 2410, 1e-6);
  EXPECT_THROW(Read(Printer(2.41, 2.41)), InputError);  // Nothing to be told.
}

}  // namespace
}  // namespace caltwin

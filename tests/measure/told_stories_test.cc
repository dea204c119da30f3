// What results and remarks tell that are no tables of readings.

#include "sim/measure/import/told_stories.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/measure/import/import.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

const FileNote* NoteOfFact(const Imported& imported, const std::string& fact) {
  const auto found = std::ranges::find(imported.notes, fact, &FileNote::fact);
  return found == imported.notes.end() ? nullptr : &*found;
}

const FileNote* NoteOf(const Imported& imported, const std::string& what) {
  const auto found = std::ranges::find(imported.notes, what, &FileNote::what);
  return found == imported.notes.end() ? nullptr : &*found;
}

double FigureOf(const FileNote& note, const std::string& key) {
  const auto found = std::ranges::find(note.figures, key, &NoteFigure::key);
  return found == note.figures.end() ? kUnknown : found->value;
}

// A run whose shape is the same, moved by a constant.
std::string TableOf(double shift_um) {
  std::string text;
  int index = 0;
  for (const double um : {4.0, 10.0, 22.0, 50.0}) {
    text += fmt::format("{}, {}, {}, {:.2f} [DELTA:{}]\n",
                        index,
                        45 + 10 * index,
                        std::round(um / 2),
                        um + shift_um,
                        index);
    ++index;
  }
  return text;
}

TEST(TemperatureTables, TellThatOnlyTheReferenceDoesNotRepeat) {
  const std::string heading = "index, temp, ustep, um\nn/a, 35, 0, 0.00\n";
  const auto told = TemperatureTablesIn(heading + TableOf(0) + "again\n" + TableOf(90));
  ASSERT_TRUE(told);
  const FileNote* note = NoteOfFact(*told, "contradiction");
  ASSERT_NE(note, nullptr);
  EXPECT_NEAR(FigureOf(*note, "spread_um"), 90, 1e-9);
  EXPECT_THAT(note->sentence, HasSubstr("100 % of the difference is one constant"));
  EXPECT_NE(NoteOf(*told, "cause"), nullptr);

  EXPECT_FALSE(TemperatureTablesIn(heading + TableOf(0) + "again\n" + TableOf(3)));
  EXPECT_FALSE(TemperatureTablesIn(heading + TableOf(0)));
  EXPECT_TRUE(TemperatureTablesIn(
      "index temp ustep um\n0 35 1 2\n1 40 2 4\n2 45 9 18\n0 35 31 62\n1 40 32 64\n"
      "2 45 39 78\n"));
}

std::string Fit(double last_mm) {
  return fmt::format(
      "Commencing calibration of parameters: ABCHR\nProbing 30 points\n"
      "A:0 B:0 C:0 H:0 R:150\nRMS error before optimization: 4.1 mm\n"
      "RMS error after iteration 1: 0.5 mm (88% improvement)\n"
      "RMS error after iteration 2: {} mm\nA:2.0 B:2.2 C:1.9 H:0.1 R:151\n",
      last_mm);
}

TEST(StalledFit, StaysFarAboveWhatAProbeScatters) {
  const auto told = StalledFitIn(Fit(0.48));
  ASSERT_TRUE(told);
  const FileNote* note = NoteOfFact(*told, "contradiction");
  ASSERT_NE(note, nullptr);
  EXPECT_NEAR(FigureOf(*note, "left_um"), 480, 1e-9);
  EXPECT_THAT(note->sentence, HasSubstr("with 5 free values"));
  EXPECT_THAT(note->sentence, HasSubstr("A, B and C went up together"));

  EXPECT_FALSE(StalledFitIn(Fit(0.03)));  // It fits.
  EXPECT_FALSE(StalledFitIn(Fit(0.2)));   // It still falls.
}

std::string Frames(double other_mm) {
  std::string text = "measured with a tape: 3000 x 2000 mm\n";
  for (const double more_mm : {0.0, 0.5 * other_mm, other_mm}) {
    text += fmt::format(
        "Frame size: {} x {} mm\nGrid: 30 x 20 mm\n", 3100 + more_mm, 1900 - more_mm);
  }
  return text;
}

TEST(SizesByRun, ThatDifferDetermineNoScale) {
  const auto told = SizesByRunIn(Frames(120));
  ASSERT_TRUE(told);
  EXPECT_NE(NoteOf(*told, "scale.x"), nullptr);
  const FileNote* note = NoteOfFact(*told, "contradiction");
  ASSERT_NE(note, nullptr);
  EXPECT_NEAR(FigureOf(*note, "width_um"), 120e3, 1e-6);
  EXPECT_THAT(note->sentence, HasSubstr("larger the height comes out smaller"));

  EXPECT_FALSE(SizesByRunIn(Frames(4)));
  EXPECT_FALSE(SizesByRunIn("G0X0Y10\nG0X10Y10\nG0X20Y10\nG0X30Y40\n"));
}

std::string Screw(double rpm_at_1600) {
  return fmt::format(
      "#define LEADSCREW_TPI 8\n#define STEPPER_RESOLUTION 800\n"
      "belt 2:1\nspindle at 200 rpm, box set to 16 TPI\nsetting  rpm\n"
      "400 pulses/rev   100\n1600 pulses/rev  {}\n",
      rpm_at_1600);
}

TEST(SpeedsByPulses, TellTheFactorThatTheSettingsMiss) {
  const auto told = SpeedsByPulsesIn(Screw(25));
  ASSERT_TRUE(told);
  const FileNote* note = NoteOf(*told, "settings");
  ASSERT_NE(note, nullptr);
  EXPECT_NEAR(FigureOf(*note, "factor"), 0.5, 1e-9);  // 50 of 100 a minute.
  EXPECT_THAT(note->sentence, HasSubstr("as much as the 2:1 of the drive"));

  EXPECT_FALSE(SpeedsByPulsesIn(Screw(40)));  // Something slips.
}

TEST(TwoSides, OfOneAxisThatDifferRackTheGantry) {
  const auto told = TwoSidesIn("X_left moved 400mm\nX_right moved 404mm\n");
  ASSERT_TRUE(told);
  const FileNote* note = NoteOfFact(*told, "scale");
  ASSERT_NE(note, nullptr);
  EXPECT_EQ(note->axis, "x");
  EXPECT_NEAR(FigureOf(*note, "factor"), 1.01, 1e-9);
  EXPECT_NE(NoteOf(*told, "cause"), nullptr);

  EXPECT_TRUE(TwoSidesIn("Y1 moves 40 cm and Y2 moves 40.3 cm\n"));
  EXPECT_FALSE(TwoSidesIn("X1 moves 400 mm\nY1 moves 404 mm\n"));
  EXPECT_FALSE(TwoSidesIn("Y1 moves 400 mm\nY2 moves 400 mm\n"));
}

std::string Delta(double trim_mm) {
  return fmt::format(
      "M665 L250.0 R120.0 A{} B0.0 C{}\nrod a: 250.1 250.2\nrod b: 249.9\n"
      "rod c: 250.0\n",
      trim_mm,
      -trim_mm / 4);
}

TEST(RodTrims, LargerThanTheRodsDifferStandInForSomethingElse) {
  const auto told = RodTrimsIn(Delta(4));
  ASSERT_TRUE(told);
  const FileNote* note = NoteOfFact(*told, "contradiction");
  ASSERT_NE(note, nullptr);
  EXPECT_NEAR(FigureOf(*note, "trims_um"), 5000, 1e-6);
  EXPECT_NEAR(FigureOf(*note, "rods_um"), 300, 1e-6);

  EXPECT_FALSE(RodTrimsIn(Delta(0.6)));
}

// Walls of 4 mm laid down `wide_mm` wider, on a machine of that scale.
std::string Print(double scale, double wide_mm) {
  std::string text = "part, drawn, measured\n";
  for (const double off_mm : {0.01, -0.01})
    text += fmt::format("wall thickness, 4, {:.3f}\n", 4 * scale + wide_mm + off_mm);
  for (const double off_mm : {0.01, -0.01})
    text +=
        fmt::format("outer distance, 104, {:.3f}\n", 104 * scale + wide_mm + off_mm);
  text += fmt::format("inner distance, 96, {:.3f}\n", 96 * scale - wide_mm);
  return text;
}

TEST(WidthsAndDistances, PartTheMachineFromTheLineLaidDown) {
  const auto right = WidthsAndDistancesIn(Print(1, 0.4));
  ASSERT_TRUE(right);
  const FileNote* slicer = NoteOf(*right, "slicer");
  ASSERT_NE(slicer, nullptr);
  EXPECT_NEAR(FigureOf(*slicer, "factor"), 1, 2e-4);

  const auto off = WidthsAndDistancesIn(Print(1.02, 0.4));
  ASSERT_TRUE(off);
  EXPECT_EQ(NoteOf(*off, "slicer"), nullptr);
  EXPECT_NEAR(FigureOf(*NoteOfFact(*off, "scale"), "factor"), 1.02, 2e-4);

  EXPECT_FALSE(WidthsAndDistancesIn(Print(1.02, 0)));
}

// Moves that a constant is added to bit by bit up to a height.
std::string Jogs(double constant_mm, double fade_mm) {
  std::string text = "z moves\ntold   real\n";
  for (const double told_mm : {2.0, 4.0, 9.0, 30.0, 50.0}) {
    const double share = fade_mm > 0 ? std::min(1.0, told_mm / fade_mm) : 1.0;
    text += fmt::format("{} {:.2f}\n", told_mm, told_mm + share * constant_mm);
  }
  return text;
}

TEST(FadedConstant, IsNoScale) {
  const auto told = FadedConstantIn(Jogs(-1.6, 12));
  ASSERT_TRUE(told);
  const FileNote* note = NoteOfFact(*told, "constant");
  ASSERT_NE(note, nullptr);
  EXPECT_NEAR(FigureOf(*note, "change_um"), -1600, 1e-6);
  EXPECT_NEAR(FigureOf(*note, "fade_um"), 12e3, 500);

  EXPECT_FALSE(FadedConstantIn(Jogs(-1.6, 0)));     // A constant from the start.
  EXPECT_FALSE(FadedConstantIn(Jogs(-1.6, 1000)));  // A scale.
}

// Sizes of a star through focus, the way back `gap` steps early.
std::string Focus(double gap, const std::string& heading) {
  std::string text = "0.002 mm per step\n" + heading + "\n";
  for (int at = 500; at <= 620; at += 10) {
    text += fmt::format("{} {:.3f} {:.3f}\n",
                        at,
                        std::hypot(2.0, (at - 566) / 15.0),
                        std::hypot(2.0, (at + gap - 566) / 15.0));
  }
  return text;
}

TEST(LeastThereAndBack, LiesALostMotionApart) {
  const auto told = LeastThereAndBackIn(Focus(17, "position FWHM moving out, FWHM in"));
  ASSERT_TRUE(told);
  ASSERT_EQ(told->notes.size(), 1U);
  EXPECT_EQ(told->notes[0].cause, "backlash");
  EXPECT_NEAR(FigureOf(told->notes[0], "gap_um"), 34, 0.5);

  EXPECT_EQ(LeastThereAndBackIn(Focus(0, "position FWHM out, FWHM in"))->notes[0].what,
            "backlash");
  EXPECT_FALSE(LeastThereAndBackIn(Focus(17, "position error out, error in")));
}

TEST(ToldStories, AreToldInPlaceOfRowsWhereAnAnswerIsAsked) {
  const std::string text = "Y1 moves 400 mm\nY2 moves 404 mm\n";
  const Imported told = ImportText("table", text, "f", {.tells_blunders = true});
  EXPECT_THAT(told.table.rows, IsEmpty());
  EXPECT_NE(NoteOfFact(told, "scale"), nullptr);
  EXPECT_THROW(ImportText("table", text, "f", {}), InputError);
}

}  // namespace
}  // namespace caltwin

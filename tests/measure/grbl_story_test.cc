// What a console of grbl tells of its own arithmetic.

#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/measure/import/import.h"

namespace caltwin {
namespace {

const FileNote* NoteOf(const Imported& imported, const std::string& what) {
  const auto found = std::ranges::find(imported.notes, what, &FileNote::what);
  return found == imported.notes.end() ? nullptr : &*found;
}

// The same move in mm and in what is reported: 15 mm are 0.59 inch.
TEST(GrblStory, AReportInInchesIsNoFaultOfTheMachine) {
  const std::string touch = ">>> G21 G91 G49\n>>> G38.2 Z-15 F150\n>>> G90 G21\nok\n";
  const Imported imported =
      ImportText("console-log",
                 touch + "[PRB:0.3883,0.1396,0.0247:1]\nok\n" +
                     ">>> G91 G21 G0 X-15.0\n>>> G90 G21\nok\n" + touch +
                     "[PRB:-0.2023,0.1396,0.0247:1]\nok\n",
                 "f",
                 {});

  const FileNote* note = NoteOf(imported, "settings");
  ASSERT_NE(note, nullptr);
  EXPECT_EQ(note->word, "inches");
  EXPECT_EQ(note->axis, "x");
}

std::string Zeroing(double touch_mm, double rest_mm) {
  const std::string status =
      "?\n<Idle|MPos:0.000,0.000,{:.3f}|WCO:0.000,0.000,{:.3f}>\n";
  return fmt::format("G91G38.2Z-30F250\n[PRB:0.000,0.000,{:.3f}:1]\nok\n", touch_mm) +
         fmt::format(fmt::runtime(status), rest_mm, 0.0) + "G90\nG10L20P1Z0\nok\n" +
         fmt::format(fmt::runtime(status), rest_mm, rest_mm) + "G53G0Z-5\nok\n";
}

TEST(GrblStory, AZeroSetWhereTheAxisStoppedIsSaidWithItsSize) {
  const Imported late = ImportText(
      "console-log",
      Zeroing(-45.340, -45.371) + Zeroing(-45.342, -45.374) + Zeroing(-45.341, -45.372),
      "f",
      {});
  const FileNote* note = NoteOf(late, "firmware");
  ASSERT_NE(note, nullptr);
  ASSERT_EQ(note->figures.size(), 1U);
  EXPECT_NEAR(note->figures[0].value, -31.333, 0.01);

  const Imported right = ImportText(
      "console-log", Zeroing(-45.340, -45.340) + Zeroing(-45.342, -45.342), "f", {});
  EXPECT_EQ(NoteOf(right, "firmware"), nullptr);
}

// A probing of X, then of Y, and where the axis stood after each.
std::string Halting(double x_mm, double x_rest_mm, double y_mm, double y_rest_mm) {
  return fmt::format(
      "G91 G21\nok\nG38.2 X15 F30\n[PRB:{0:.3f},0.000,0.000:1]\nok\n?\n"
      "<Idle|MPos:{1:.3f},0.000,0.000|FS:0,0>\nG0 X-4\nok\nG38.2 Y-15 F30\n"
      "[PRB:{1:.3f},{2:.3f},0.000:1]\nok\n?\n<Idle|MPos:{1:.3f},{3:.3f},0.000|FS:0,0>"
      "\n",
      x_mm,
      x_rest_mm,
      y_mm,
      y_rest_mm);
}

TEST(GrblStory, TheRestBeyondTheContactIsTheWayToAHalt) {
  const Imported late =
      ImportText("console-log", Halting(6.200, 6.262, -3.100, -3.160), "f", {});
  const FileNote* note = NoteOf(late, "settings");
  ASSERT_NE(note, nullptr);
  EXPECT_EQ(note->word, "overtravel");
  EXPECT_NEAR(note->figures[0].value, 61, 1e-6);

  // Told in absolute places: X from +20 back to 15.
  const Imported absolute = ImportText(
      "console-log",
      "G90\nG38.2 X15 F30\n[PRB:17.200,0.000,0.000:1]\n?\n"
      "<Idle|MPos:17.140,0.000,0.000|FS:0,0>\nG0 X30\nG38.2 Z-9 F30\n"
      "[PRB:30.000,0.000,-3.100:1]\n?\n<Idle|MPos:30.000,0.000,-3.162|FS:0,0>\n",
      "f",
      {});
  ASSERT_NE(NoteOf(absolute, "settings"), nullptr);
  EXPECT_EQ(NoteOf(absolute, "settings")->word, "overtravel");

  // On the near side of one contact: no halt does that.
  const Imported other =
      ImportText("console-log", Halting(6.200, 6.262, -3.100, -3.040), "f", {});
  EXPECT_EQ(NoteOf(other, "settings"), nullptr);
}

// Touches at places told in absolute coordinates, the report moved by `off_mm`.
std::string Touches(double off_mm) {
  std::string text = "$100=30.000\n$101=30.000\n[G54:2.000,0.000,0.000]\n";
  for (const double x_mm : {5.08, 11.11, 19.25}) {
    const double at_mm = std::round((x_mm + 2) * 30) / 30 + off_mm;
    text += fmt::format(
        "G90G0X{:.3f}\nok\nG91 G38.2 Z-9 F80\n[PRB:{:.3f},0.000,-1.000:1]\nok\n",
        x_mm,
        at_mm);
  }
  return text;
}

TEST(GrblStory, PlacesOfTouchesAreTheNearestWholeSteps) {
  const Imported rounded = ImportText("console-log", Touches(0), "f", {});
  const FileNote* note = NoteOf(rounded, "firmware");
  ASSERT_NE(note, nullptr);
  EXPECT_EQ(note->fact, "steps");
  EXPECT_NEAR(note->figures[0].value, 1000.0 / 30, 1e-9);

  const Imported lost = ImportText("console-log", Touches(1 / 30.0), "f", {});
  EXPECT_EQ(NoteOf(lost, "firmware"), nullptr);
}

}  // namespace
}  // namespace caltwin

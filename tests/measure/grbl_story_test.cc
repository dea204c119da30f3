// What a console of grbl tells of its own arithmetic.

#include <algorithm>
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

}  // namespace
}  // namespace caltwin

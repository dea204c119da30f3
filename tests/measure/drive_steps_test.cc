// Steps/mm as set against those that the drive needs.

#include <algorithm>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/measure/import/import.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;

Imported Read(const std::string& text) {
  return ImportText(KindOrFound("", text, "f"), text, "f", {.tells_blunders = true});
}

const FileNote* NoteOf(const Imported& imported, const std::string& what) {
  const auto found = std::ranges::find(imported.notes, what, &FileNote::what);
  return found == imported.notes.end() ? nullptr : &*found;
}

// 20 teeth of 2 mm at 0.9 degrees: 10 full steps/mm.
std::string Settings(int microsteps) {
  return fmt::format(
      "echo:  M92 X160.00 Y160.00 Z400.00\nX_MICROSTEPS: {}\n"
      "20 teeth, GT2, 0.9 deg motors\nG1 X40   moves 80\nG1 Y30   moves 60\n"
      "G1 Z10   travels 10\n",
      microsteps);
}

TEST(DriveSteps, OfOtherMicrostepsAreAFactorOfTwo) {
  const Imported imported = Read(Settings(8));
  EXPECT_THAT(imported.table.rows, SizeIs(3));
  const FileNote* note = NoteOf(imported, "M92");
  ASSERT_NE(note, nullptr);
  EXPECT_EQ(note->fact, "ratio");
  EXPECT_EQ(note->figures[0].value, 2);
  EXPECT_THAT(note->sentence, HasSubstr("moves are 2 times as long as told"));
  EXPECT_THAT(note->sentence, HasSubstr("Set M92 X80 Y80"));

  EXPECT_EQ(NoteOf(Read(Settings(16)), "M92"), nullptr);
}

}  // namespace
}  // namespace caltwin

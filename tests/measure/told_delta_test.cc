// A map of a machine that the text calls a delta and does not describe.

#include <algorithm>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/measure/import/import.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;

Imported Read(const std::string& text) {
  return ImportText(KindOrFound("", text, "f"), text, "f", {.tells_blunders = true});
}

const FileNote* NoteOf(const Imported& imported, const std::string& what) {
  const auto found = std::ranges::find(imported.notes, what, &FileNote::what);
  return found == imported.notes.end() ? nullptr : &*found;
}

const FileNote* NoteOfFact(const Imported& imported, const std::string& fact) {
  const auto found = std::ranges::find(imported.notes, fact, &FileNote::fact);
  return found == imported.notes.end() ? nullptr : &*found;
}

std::string Map(const std::string& remark) {
  return "x 0 40 80\ny 0 1.1 1.0 1.2\ny 40 1.0 1.3 1.1\ny 80 1.2 1.1 0.9\n" + remark;
}

TEST(ToldDelta, OfAMapWithoutItsGeometryLeavesGantriesOut) {
  const Imported delta = Read(Map("my kossel, glass bed\n"));
  EXPECT_EQ(delta.told_kind, "delta");
  EXPECT_NE(NoteOf(delta, "cause"), nullptr);

  EXPECT_EQ(NoteOfFact(delta, "twist"), nullptr);  // Neither saddle nor bowl.
  EXPECT_EQ(Read(Map("[DELTA:4]\n")).told_kind, "");
  EXPECT_EQ(Read(Map("glass bed\n")).told_kind, "");
  EXPECT_EQ(Read(Map("the delta between corners is too much\n")).told_kind, "");
  const std::string text = Map("my kossel\n");
  const Imported named = ImportText(KindOrFound("", text, "f"),
                                    text,
                                    "f",
                                    {.tells_blunders = true, .has_machine = true});
  EXPECT_EQ(named.told_kind, "");
}

TEST(ToldDelta, ASaddleIsTheTowersAnglesAndABowlTheRadius) {
  const Imported saddle = Read(
      "x -60 0 60\ny -60 0.52 0.01 -0.49\ny 0 0.00 0.02 -0.01\n"
      "y 60 -0.50 0.00 0.51\nmy delta.\n");
  const FileNote* twist = NoteOfFact(saddle, "twist");
  ASSERT_NE(twist, nullptr);
  EXPECT_NEAR(twist->figures[0].value, 1010, 5);
  EXPECT_THAT(twist->sentence, HasSubstr("the angles of the towers"));

  const Imported bowl = Read(
      "x -60 0 60\ny -60 0.60 0.31 0.60\ny 0 0.30 0.00 0.29\ny 60 0.61 0.30 0.60\n"
      "my delta.\n");
  const FileNote* form = NoteOfFact(bowl, "form");
  ASSERT_NE(form, nullptr);
  EXPECT_NEAR(form->figures[0].value, 600, 10);
  EXPECT_THAT(form->sentence, HasSubstr("the delta radius"));
}

}  // namespace
}  // namespace caltwin

// Several meshes in one console: where one ends, what was never measured, and a zero
// that moved.

#include <algorithm>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/measure/import/import.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;

Imported Read(const std::string& text) {
  return ImportText("console-log", text, "f", {});
}

const FileNote* NoteOf(const Imported& imported, const std::string& what) {
  const auto found = std::ranges::find(imported.notes, what, &FileNote::what);
  return found == imported.notes.end() ? nullptr : &*found;
}

// Three rows of four, the last column as given.
std::string Rows(double height_mm, double last_factor) {
  std::string text;
  for (int row = 0; row < 3; ++row) {
    text += fmt::format(" {} {:+.3f} {:+.3f} {:+.3f} {:+.3f}\n",
                        row,
                        height_mm + 0.013 * row,
                        height_mm - 0.021,
                        height_mm + 0.034 - 0.007 * row,
                        last_factor * (height_mm - 0.055 - 0.01 * row));
  }
  return text;
}

const char* const kTitle = "Bilinear Leveling Grid:\n";
const char* const kColumns = "      0      1      2      3\n";

TEST(ConsoleMeshes, OneHeadingOfTwoMeshesIsNoneOfTwiceTheRows) {
  for (const std::string& between :
       {std::string(kColumns), "before\n" + std::string(kColumns), std::string()}) {
    const Imported imported =
        Read(kTitle + std::string(kColumns) + Rows(0.1, 1) + between + Rows(0.2, 1));

    ASSERT_THAT(imported.table.rows, SizeIs(24)) << between;
    const Row& last = imported.table.rows.back();
    EXPECT_EQ(last.cmd_mm[1], 2) << between;
    EXPECT_EQ(last.campaign, "mesh_2") << between;
  }
}

TEST(ConsoleMeshes, AColumnOfNothingButNoughtsWasNotMeasured) {
  const std::string title = kTitle + std::string(kColumns);
  const Imported imported =
      Read(title + Rows(0.1, 0) + "ok\n" + title + Rows(0.1, 1) + "ok\n");

  EXPECT_THAT(imported.table.rows, SizeIs(21));
  const FileNote* note = NoteOf(imported, "firmware");
  ASSERT_NE(note, nullptr);
  EXPECT_THAT(note->sentence, HasSubstr("All 3 points of column 3"));
  EXPECT_THAT(note->sentence, HasSubstr("the other 9 points agree to 0 um"));

  const Imported whole = Read(title + Rows(0.1, 1) + "ok\n");
  EXPECT_EQ(NoteOf(whole, "firmware"), nullptr);
}

TEST(ConsoleMeshes, AConstantAfterAnUpdateIsTheSettings) {
  const std::string title = kTitle + std::string(kColumns);
  const std::string meshes =
      title + Rows(0.1, 1) + "ok\n" + title + Rows(1.3, 1) + "ok\n";
  const Imported imported = Read("flashed 2.1 in between\n" + meshes);

  const FileNote* note = NoteOf(imported, "settings");
  ASSERT_NE(note, nullptr);
  EXPECT_THAT(note->sentence, HasSubstr("+1.20 mm"));
  EXPECT_EQ(NoteOf(Read(meshes), "settings"), nullptr);
}

}  // namespace
}  // namespace caltwin

// Grids of heights without a word beside them, and what else is no table.

#include "sim/measure/import/bare_grid.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/measure/import/console_story.h"
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
}

TEST(Recognise, TellsModulesAndMacrosFromTables) {
  EXPECT_EQ(
      KindOfText("[z_tilt]\nz_positions:\n  20, 20\n  300, 20\nretries: 5\n", "f"),
      "printer-cfg");
  EXPECT_EQ(KindOfText("; bed.g\nM561\nG28 ; home\nG30 P0 X0 Y0 Z-9999\nG1 Z5\n", "f"),
            "rrf-config");
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

}  // namespace
}  // namespace caltwin

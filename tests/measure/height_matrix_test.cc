#include "sim/measure/import/height_matrix.h"

#include <gtest/gtest.h>

namespace caltwin {
namespace {

TEST(HeightMatrix, PlacesStandBesideTheHeights) {
  const auto matrix = HeightMatrixIn(
      "the bed\nX: -80 0 80\ny: 80 12.45 12.79 13.48\ny: 0 12.91 12.63 13.00\n"
      "y: -80 13.61 12.95 12.29\nsomething else\n");

  ASSERT_TRUE(matrix);
  EXPECT_EQ(matrix->x_mm, (std::vector<double>{-80, 0, 80}));
  EXPECT_EQ(matrix->y_mm, (std::vector<double>{80, 0, -80}));
  EXPECT_EQ(matrix->heights_mm[2][0], 13.61);
  EXPECT_EQ(matrix->line, 2);
}

TEST(HeightMatrix, ACornerMayBeEmptyAndCommasMaySeparate) {
  EXPECT_TRUE(HeightMatrixIn("10, 20, 30\n0, 1, 2, 3\n5, 1, 2, 3\n10, 1, 2, 3\n"));
}

TEST(HeightMatrix, OtherTablesAreNone) {
  // Places that are not even, a column too few, words, too few lines.
  EXPECT_FALSE(HeightMatrixIn("10 20 35\n0 1 2 3\n5 1 2 3\n10 1 2 3\n"));
  EXPECT_FALSE(HeightMatrixIn("10 20 30\n0 1 2\n5 1 2\n10 1 2\n"));
  EXPECT_FALSE(HeightMatrixIn("commanded 10 20\n0 1 2 3\n5 1 2 3\n10 1 2 3\n"));
  EXPECT_FALSE(HeightMatrixIn("10 20 30\n0 1 2 3\n5 1 2 3\n"));
  // Numbers of points.
  EXPECT_FALSE(HeightMatrixIn("0 1 2\n0 1 2 3\n1 1 2 3\n2 1 2 3\n"));
}

TEST(HeightMatrix, EveryHeightIsATouch) {
  const Imported imported = ReadHeightMatrix(
      "X: 0 100 200\nY: 0 1 2 3\nY: 50 4 5 6\nY: 100 7 8 9\n", "map.txt", {});

  ASSERT_EQ(imported.table.rows.size(), 9u);
  EXPECT_EQ(imported.table.rows[5].cmd_mm[0], 200);
  EXPECT_EQ(imported.table.rows[5].cmd_mm[1], 50);
  EXPECT_THROW(ReadHeightMatrix("nothing\n", "map.txt", {}), InputError);
}

}  // namespace
}  // namespace caltwin

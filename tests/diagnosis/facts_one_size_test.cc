// Parts of one size: how much too large, and nothing more.

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/facts/one_size.h"
#include "tests/diagnosis/facts_of.h"

namespace caltwin {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

Row Size(int axis, double size_mm, double error_mm) {
  Row row{.kind = RowKind::kPosition};
  row.cmd_mm = {kUnknown, kUnknown, kUnknown};
  row.cmd_mm[static_cast<std::size_t>(axis)] = size_mm;
  row.n = {0, 0, 0};
  row.n[static_cast<std::size_t>(axis)] = 1;
  row.dir = {kUnknown, kUnknown, kUnknown};
  row.value_mm = error_mm;
  return row;
}

TEST(OneSize, SaysTheErrorAndThatItTellsNoScale) {
  const Facts facts = FactsOfRows({Size(0, 20, 0.05), Size(2, 25, -0.5)});
  const Fact* x = facts.Find("one_size");
  ASSERT_NE(x, nullptr);
  EXPECT_NEAR(FigureOf(*x, "change_um"), 50, 1e-9);
  EXPECT_NEAR(FigureOf(*x, "size_mm"), 20, 1e-9);
  EXPECT_THAT(x->sentence, HasSubstr("20 mm along X is too large by 0.05 mm (0.25 %)"));
  EXPECT_FALSE(x->is_answer);
  EXPECT_THAT(facts.all.back().sentence, HasSubstr("25 mm along Z is too small"));
}

// Four parts: the mean, and its standard deviation is that of four over two.
TEST(OneSize, OfRepeatsIsTheirMean) {
  const Facts facts = FactsOfRows(
      {Size(0, 20, 0.19), Size(0, 20, 0.21), Size(0, 20, 0.19), Size(0, 20, 0.21)});
  const Fact* x = facts.Find("one_size");
  ASSERT_NE(x, nullptr);
  EXPECT_NEAR(FigureOf(*x, "change_um"), 200, 1e-9);
  EXPECT_NEAR(x->figures[0].sd, 1e3 * 0.02 / std::sqrt(3.0) / 2, 1e-6);
}

TEST(OneSize, TwoSizesTellMore) {
  const Facts facts = FactsOfRows({Size(0, 20, 0.05), Size(0, 100, 0.25)});
  EXPECT_EQ(facts.Find("one_size"), nullptr);
}

// Material shrinks as a scale does, and never grows nor by a tenth; a move is no part.
TEST(OneSize, OfSmallerPartsShrinkageIsThought) {
  const auto says = [](double factor, const std::string& flag) {
    std::vector<Row> rows;
    for (const double size_mm : {50.0, 100.0, 150.0, 200.0}) {
      rows.push_back(Size(0, size_mm, (factor - 1) * size_mm));
      rows.back().flag = flag;
    }
    const Facts facts = FactsOfRows(std::move(rows));
    const Fact* scale = facts.Find("scale");
    return scale == nullptr ? std::string("nothing") : scale->sentence;
  };
  EXPECT_THAT(says(0.995, ""), HasSubstr("material that shrinks"));
  EXPECT_THAT(says(1.005, ""), AllOf(HasSubstr("multiply"), Not(HasSubstr("shrinks"))));
  EXPECT_THAT(says(0.93, ""), AllOf(HasSubstr("multiply"), Not(HasSubstr("shrinks"))));
  EXPECT_THAT(says(0.995, "move"),
              AllOf(HasSubstr("multiply"), Not(HasSubstr("shrinks"))));
}

}  // namespace
}  // namespace caltwin

// What one kind of reading says of another, and several campaigns of one axis.

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "sim/base/rng.h"
#include "tests/diagnosis/facts_of.h"

namespace caltwin {
namespace {

Row TouchOf(const std::string& campaign, double x_mm, double y_mm, double value_mm) {
  Row row{.campaign = campaign,
          .kind = RowKind::kTouch,
          .setup = "bed",
          .feature = "bed.top"};
  row.cmd_mm = {x_mm, y_mm, 0};
  row.dir[2] = -1;
  row.n = {0, 0, 1};
  row.value_mm = value_mm;
  return row;
}

// Twenty places along X and more, each read twice.
std::vector<Row> LaserOf(const std::string& campaign, int num, double sd_mm, Rng* rng) {
  std::vector<Row> rows;
  for (int i = 0; i < num; ++i) {
    const int place = i / 2;
    Row row{.campaign = campaign, .kind = RowKind::kPosition, .setup = "laser"};
    row.cmd_mm = {10.0 * place, 0, 0};
    row.n = {1, 0, 0};
    row.value_mm = sd_mm * rng->Normal();
    rows.push_back(row);
  }
  return rows;
}

// Readings of a laser, which scatter less, do not say how touches scatter: a flat mesh
// beside them is flat, an uneven one uneven.
TEST(FactsOfNoise, AMeshIsHeldAgainstTouchesAlone) {
  constexpr double kTouch_mm = 0.002, kLaser_mm = 0.0003;
  for (const double uneven_mm : {0.0, 0.02}) {
    Rng rng(11, static_cast<std::uint64_t>(uneven_mm * 1000), "facts.mesh");
    std::vector<Row> rows = LaserOf("laser", 60, kLaser_mm, &rng);
    for (int i = 0; i < 16; ++i) {
      rows.push_back(TouchOf("repeats", 5, 5, kTouch_mm * rng.Normal()));
    }
    for (int i = 0; i < 25; ++i) {
      const int column = i % 5, line = i / 5;
      const double wave_mm = uneven_mm * std::cos(2.0 * column);
      rows.push_back(TouchOf(
          "mesh", 40.0 * column, 40.0 * line, wave_mm + kTouch_mm * rng.Normal()));
    }

    const Facts facts = FactsOfRows(rows);

    const Fact* const form = facts.Find("form");
    ASSERT_NE(form, nullptr);
    EXPECT_EQ(form->is_answer, uneven_mm > 0) << form->sentence;
  }
}

// What nothing speaks against is said of each axis once, by its surest campaign.
TEST(FactsOfNoise, StepsThatAgreeAreSaidOnceForAnAxis) {
  Rng rng(5, 1, "facts.scale");
  std::vector<Row> rows = LaserOf("fine", 40, 0.001, &rng);
  const std::vector<Row> rough = LaserOf("rough", 40, 0.005, &rng);
  rows.insert(rows.end(), rough.begin(), rough.end());

  const Facts facts = FactsOfRows(rows);

  std::vector<const Fact*> scales;
  for (const Fact& fact : facts.all) {
    if (fact.id == "scale") scales.push_back(&fact);
  }
  ASSERT_EQ(scales.size(), 1u);
  EXPECT_LT(scales.front()->figures.front().sd, 1e-5);
}

}  // namespace
}  // namespace caltwin

// Meshes of the same places, against closed forms.

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/rng.h"
#include "tests/diagnosis/facts_of.h"

namespace caltwin {
namespace {

constexpr int kSide = 7;

/// A bed of a known shape: a step of the given height at its front edge, or one place.
struct Bed {
  double front_mm = 0, middle_mm = 0, sigma_mm = 0.005;
};

std::vector<Row> Mesh(const std::string& campaign, const Bed& bed, double height_mm) {
  Rng rng(campaign.size(), 0, campaign.c_str());
  std::vector<Row> rows;
  for (int j = 0; j < kSide; ++j) {
    for (int i = 0; i < kSide; ++i) {
      Row row{.campaign = campaign,
              .kind = RowKind::kTouch,
              .setup = "bed",
              .feature = "bed.top"};
      row.cmd_mm = {40.0 * i, 40.0 * j, 0};
      row.dir[2] = -1;
      row.n = {0, 0, 1};
      row.value_mm = height_mm + bed.sigma_mm * rng.Normal();
      if (j == 0) row.value_mm += bed.front_mm;
      if (i == 3 && j == 3) row.value_mm += bed.middle_mm;
      rows.push_back(std::move(row));
    }
  }
  return rows;
}

std::vector<Row> Both(std::vector<Row> one, std::vector<Row> other) {
  for (Row& row : other) one.push_back(std::move(row));
  return one;
}

TEST(FactsOfMeshes, RepeatToTheNoiseOfATouch) {
  const Facts facts = FactsOfRows(Both(Mesh("first", {}, 0), Mesh("second", {}, 0.3)));

  const Fact* fact = facts.Find("repeatability");
  ASSERT_NE(fact, nullptr);
  EXPECT_EQ(fact->word, "meshes");
  EXPECT_NEAR(fact->figures[0].value, 5, 3 * fact->figures[0].sd);
  EXPECT_NEAR(fact->figures[1].value, 300, 5);
  EXPECT_THAT(facts.not_determined, testing::Not(testing::Contains("uncertainty")));
}

TEST(FactsOfSurface, APlaceOffInBothMeshesIsTheBeds) {
  const Bed dented{.middle_mm = 0.3};
  EXPECT_EQ(FactsOfRows(Both(Mesh("first", dented, 0), Mesh("second", dented, 0)))
                .Find("outliers"),
            nullptr);
  EXPECT_NE(FactsOfRows(Both(Mesh("first", dented, 0), Mesh("second", {}, 0)))
                .Find("outliers"),
            nullptr);
  EXPECT_NE(FactsOfRows(Mesh("first", dented, 0)).Find("outliers"), nullptr);
}

TEST(FactsOfSurface, AnEdgeThatRisesIsNoRowOfBadTouches) {
  EXPECT_EQ(FactsOfRows(Mesh("first", {.front_mm = 0.3}, 0)).Find("outliers"), nullptr);
}

}  // namespace
}  // namespace caltwin

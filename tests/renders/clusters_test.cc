#include "renders/clusters.h"

#include <cmath>

#include <gtest/gtest.h>

namespace caltwin {
namespace {

Row Touch(const char* feature, double nx, double value_mm) {
  return {.kind = RowKind::kTouch,
          .dir = {-nx, 0, 0},
          .n = {nx, 0, 0},
          .feature = feature,
          .value_mm = value_mm};
}

TEST(Clusters, AreOneAFeatureAndDirection) {
  RowTable table;
  table.rows = {Touch("block.left", -1, 0.01),
                Touch("block.right", 1, 0.02),
                Touch("block.left", -1, 0.03)};

  const std::vector<Cluster> clusters = ClustersOf(table);

  ASSERT_EQ(clusters.size(), 2);
  EXPECT_EQ(clusters[0].feature, "block.left");
  EXPECT_EQ(clusters[0].approach, "+x");
  EXPECT_EQ(clusters[0].value_mm.size(), 2);
  EXPECT_EQ(clusters[1].approach, "-x");
}

TEST(Clusters, KeepSettingsApart) {
  RowTable table;
  table.rows = {Touch("block.left", -1, 0.01), Touch("block.left", -1, 0.01)};
  table.rows[1].settings = "2";

  EXPECT_EQ(ClustersOf(table).size(), 2);
}

TEST(Clusters, KeepPointsOfAPlaneApart) {
  RowTable table;
  table.rows = {Touch("bed.top", 0, 0.01), Touch("bed.top", 0, 0.02)};
  table.rows[0].cmd_mm = {10, 10, 0};
  table.rows[1].cmd_mm = {200, 10, 0};

  EXPECT_EQ(ClustersOf(table).size(), 2);
}

TEST(Clusters, LeaveOutWhatAGaugeRead) {
  RowTable table;
  table.rows = {Touch("block.left", -1, 0.01)};
  table.rows[0].kind = RowKind::kPosition;

  EXPECT_TRUE(ClustersOf(table).empty());
}

TEST(Clusters, HaveMeanScatterAndRange) {
  const Cluster cluster{.value_mm = {1, 2, 3}};

  EXPECT_DOUBLE_EQ(cluster.mean_mm(), 2);
  EXPECT_DOUBLE_EQ(cluster.sd_mm(), 1);
  EXPECT_DOUBLE_EQ(cluster.range_mm(), 2);
}

}  // namespace
}  // namespace caltwin

#include <array>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "calibration/estimate/clusters.h"
#include "sim/base/rng.h"

namespace caltwin {
namespace {

TEST(StudentTwoSided, HasTheTabulatedQuantiles) {
  // Two-sided 5 % and 1 % points of the printed tables, whose last digit moves p by as
  // much as half of it times twice the density.
  constexpr double kPrinted = 5e-4 * 2 * 0.05;
  EXPECT_NEAR(StudentTwoSided(12.706, 1), 0.05, kPrinted);
  EXPECT_NEAR(StudentTwoSided(4.303, 2), 0.05, kPrinted);
  EXPECT_NEAR(StudentTwoSided(3.182, 3), 0.05, kPrinted);
  EXPECT_NEAR(StudentTwoSided(2.306, 8), 0.05, kPrinted);
  EXPECT_NEAR(StudentTwoSided(3.355, 8), 0.01, kPrinted);
  EXPECT_NEAR(StudentTwoSided(2.921, 16), 0.01, kPrinted);
  EXPECT_NEAR(StudentTwoSided(-2.131, 15), 0.05, kPrinted);
}

TEST(Clusters, MeansAndScatterAreTakenByClusters) {
  const std::array plus{1.0, 3.0};
  const std::array minus{10.0, 10.0};

  const ClusterStatistics statistics = CompareClusters(plus, minus, 0);

  EXPECT_DOUBLE_EQ(statistics.mean_plus_mm, 2);
  EXPECT_DOUBLE_EQ(statistics.mean_minus_mm, 10);
  EXPECT_DOUBLE_EQ(statistics.scatter_plus_mm, std::numbers::sqrt2);
  EXPECT_DOUBLE_EQ(statistics.scatter_minus_mm, 0);
}

TEST(Clusters, ScatterAboveFiveMicrometresIsWarnedAbout) {
  const std::array quiet{0.0, 0.006};  // standard deviation 4.2 um
  const std::array loose{0.0, 0.008};  // 5.7 um

  EXPECT_FALSE(CompareClusters(quiet, quiet, 0).scatter_warning);
  EXPECT_TRUE(CompareClusters(quiet, loose, 0).scatter_warning);
}

TEST(Clusters, PublishedGapIsTheDistanceOfTheMeans) {
  const std::array plus{0.10, 0.12};
  const std::array minus{0.05, 0.07};

  const Uncertain gap = ClusterGapAsPublished(plus, minus, 0);

  EXPECT_NEAR(gap.value, 0.05, 1e-12);
  // Both variances 2e-4: sd of a difference of two means of two.
  EXPECT_NEAR(gap.sd, std::sqrt(2e-4), 1e-12);
}

TEST(Clusters, ReadingsOnNeighbouringStepsCanStillBeOneCluster) {
  // No scatter at all, one step apart: rounding alone explains it.
  const std::array plus{0.0, 0.0};
  const std::array minus{0.001, 0.001};

  EXPECT_TRUE(CompareClusters(plus, minus, 0.001).one_cluster);
  EXPECT_FALSE(CompareClusters(plus, minus, 0).one_cluster);
}

TEST(Clusters, TheSeedsTestMissesAGapThatStudentSees) {
  const std::array plus{0.0000, 0.0002, 0.0001, 0.0002, 0.0000};
  const std::array minus{0.0060, 0.0062, 0.0061, 0.0062, 0.0060};

  const ClusterStatistics statistics = CompareClusters(plus, minus, 0);

  EXPECT_TRUE(statistics.one_cluster_as_published);
  EXPECT_FALSE(statistics.one_cluster);
}

TEST(Clusters, OneReadingEachIsNotIdentifiable) {
  const std::array one{0.0};

  EXPECT_FALSE(CompareClusters(one, one, 0.001).identifiable);
  EXPECT_FALSE(ClusterGapAsPublished(one, one, 0.001).identifiable);
}

TEST(Clusters, OneClusterIsTakenForTwoOnceInAHundred) {
  constexpr int kTrials = 20000;
  constexpr double kRate = 0.01;
  Rng rng(11, 0, "clusters");
  int false_alarms = 0;

  for (int trial = 0; trial < kTrials; ++trial) {
    std::array<double, 5> plus{};
    std::array<double, 5> minus{};
    for (double& reading : plus) reading = rng.Normal();
    for (double& reading : minus) reading = rng.Normal();
    if (!CompareClusters(plus, minus, 0).one_cluster) ++false_alarms;
  }

  const double sd = std::sqrt(kRate * (1 - kRate) / kTrials);
  EXPECT_NEAR(static_cast<double>(false_alarms) / kTrials, kRate, 4 * sd);
}

}  // namespace
}  // namespace caltwin

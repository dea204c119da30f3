#include "scenarios/position_error.h"

#include <gtest/gtest.h>

namespace caltwin {
namespace {

// 1 to 100 to either side of a point far from nought: 95 of each hundred lie within 95.
TEST(PositionError, P95IsAboutTheMean) {
  const Vec3<double> offset_mm(7, -300, 40), along(0.6, 0, 0.8);
  std::vector<Vec3<double>> errors_mm;
  for (int i = 1; i <= 100; ++i) {
    errors_mm.push_back(offset_mm + i * along);
    errors_mm.push_back(offset_mm - i * along);
  }

  EXPECT_NEAR(P95AboutMean_mm(errors_mm), 95, 1e-9);
}

}  // namespace
}  // namespace caltwin

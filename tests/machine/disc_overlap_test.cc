#include "sim/machine/disc_overlap.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace caltwin {
namespace {

TEST(FirstContact, OnAWideFaceIsTheRimUphill) {
  const DiscOverFace wide{.radius_mm = 6, .half_mm = {50, 50}};

  const Eigen::Vector2d contact_mm = FirstContact_mm(wide, {3, 4});

  EXPECT_NEAR(contact_mm.x(), 3.6, 1e-12);
  EXPECT_NEAR(contact_mm.y(), 4.8, 1e-12);
}

TEST(FirstContact, OnALevelFaceIsUnderTheDisc) {
  const DiscOverFace wide{.disc_mm = {1, 2}, .radius_mm = 6, .half_mm = {50, 50}};

  EXPECT_EQ(FirstContact_mm(wide, {0, 0}), Eigen::Vector2d(1, 2));
}

TEST(FirstContact, IsNowhereLowerThanAnyPointOfTheOverlap) {
  const DiscOverFace edge{.disc_mm = {2, 23}, .radius_mm = 6, .half_mm = {20, 20}};
  for (int k = 0; k < 16; ++k) {
    const double angle_rad = std::numbers::pi * k / 8 + 0.1;
    const Eigen::Vector2d uphill(std::cos(angle_rad), std::sin(angle_rad));

    const double found_mm = uphill.dot(FirstContact_mm(edge, uphill));

    for (int i = 0; i <= 48; ++i) {
      for (int j = 0; j <= 12; ++j) {
        const Eigen::Vector2d point(-4 + 0.25 * i, 17 + 0.25 * j);
        if ((point - edge.disc_mm).norm() > edge.radius_mm) continue;
        EXPECT_GE(found_mm, uphill.dot(point) - 1e-9) << k;
      }
    }
  }
}

}  // namespace
}  // namespace caltwin

#include <cmath>

#include <gtest/gtest.h>

#include "sim/firmware/plant.h"

namespace caltwin {
namespace {

// 50 mm at 20 mm/s and 100 mm/s^2 from rest to rest: 0.2 s up over 2 mm, 46 mm along
// in 2.3 s, 0.2 s down.
constexpr Profile kTrapezoid{.length_mm = 50,
                             .feed_in_mm_s = 0,
                             .feed_top_mm_s = 20,
                             .feed_out_mm_s = 0,
                             .acceleration_mm_s2 = 100};

TEST(Profile, TrapezoidTakesItsClosedFormTime) {
  EXPECT_DOUBLE_EQ(kTrapezoid.Duration_s(), 0.2 + 2.3 + 0.2);
}

TEST(Profile, DistanceIsTheIntegralOfTheFeed) {
  Profile profile = kTrapezoid;
  profile.feed_in_mm_s = 5;
  profile.feed_out_mm_s = 10;
  const double step_s = 1e-4;
  double gone_mm = 0;
  double worst_mm = 0;
  double t_s = 0;
  for (; t_s + step_s < profile.Duration_s(); t_s += step_s) {
    worst_mm = std::max(worst_mm, std::abs(gone_mm - profile.Distance_mm(t_s)));
    gone_mm += (profile.Feed_mm_s(t_s) + profile.Feed_mm_s(t_s + step_s)) / 2 * step_s;
  }

  // The trapezoid rule errs only in the two steps that hold a corner.
  const double neglected = 2 * profile.acceleration_mm_s2 * step_s * step_s;
  EXPECT_LT(worst_mm, neglected);
  EXPECT_DOUBLE_EQ(profile.Distance_mm(profile.Duration_s()), 50);
  EXPECT_DOUBLE_EQ(profile.Distance_mm(1e9), 50);
  EXPECT_DOUBLE_EQ(profile.Distance_mm(-1), 0);
}

TEST(Profile, FeedEndsAreThoseOfTheJunctions) {
  Profile profile = kTrapezoid;
  profile.feed_in_mm_s = 5;
  profile.feed_out_mm_s = 10;

  EXPECT_DOUBLE_EQ(profile.Feed_mm_s(0), 5);
  EXPECT_DOUBLE_EQ(profile.Feed_mm_s(profile.Duration_s()), 10);
}

TEST(Segment, EndsExactlyOnItsLastStep) {
  const Segment segment{.from_steps = Vec3<double>(0, 10, -3),
                        .to_steps = Vec3<double>(40000, 11, -7),
                        .profile = kTrapezoid};

  EXPECT_EQ(segment.Steps(0), segment.from_steps);
  EXPECT_EQ(segment.Steps(2.7), segment.to_steps);
  EXPECT_DOUBLE_EQ(segment.Steps(0.2)[0], 40000.0 * 2 / 50);
}

}  // namespace
}  // namespace caltwin

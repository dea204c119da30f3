#include <array>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "calibration/estimate/backlash.h"
#include "sim/base/rng.h"

namespace caltwin {
namespace {

constexpr double kBacklash_mm = 0.05;
constexpr double kHysteresis_mm = 0.002;
constexpr double kLatency_s = 0.0004;

// Trigger less release from the two moves themselves: in, the carriage lags by b / 2;
// out, it leads by it, and the switch opens `hysteresis` earlier.
double Difference_mm(double feed_mm_s) {
  const double face_mm = 40;
  const double pretravel_mm = 0.02;
  const double trigger_mm =
      face_mm + pretravel_mm + kBacklash_mm / 2 + feed_mm_s * kLatency_s;
  const double release_mm = face_mm + pretravel_mm - kHysteresis_mm - kBacklash_mm / 2 -
                            feed_mm_s * kLatency_s;
  return trigger_mm - release_mm;
}

std::vector<TriggerRelease> Feeds(std::initializer_list<double> feeds_mm_s,
                                  double sd_mm = 0.001) {
  std::vector<TriggerRelease> readings;
  for (const double feed_mm_s : feeds_mm_s) {
    readings.push_back({feed_mm_s, {Difference_mm(feed_mm_s), sd_mm}});
  }
  return readings;
}

TEST(BacklashFromRelease, TwoFeedsRecoverBacklashAndLatency) {
  const ReleaseFit fit =
      BacklashFromRelease(Feeds({1, 5}), {.value = kHysteresis_mm, .sd = 0});

  EXPECT_TRUE(fit.backlash_mm.identifiable);
  EXPECT_NEAR(fit.backlash_mm.value, kBacklash_mm, 1e-9);
  EXPECT_NEAR(fit.latency_s.value, kLatency_s, 1e-9);
}

TEST(BacklashFromRelease, ExtrapolationCostsWhatTheLeverSays) {
  const ReleaseFit fit =
      BacklashFromRelease(Feeds({1, 5}), {.value = kHysteresis_mm, .sd = 0});

  // b = (5 d1 - 1 d5) / 4 - h.
  EXPECT_NEAR(fit.backlash_mm.sd, 0.001 * std::sqrt(25.0 + 1) / 4, 1e-8);
}

TEST(BacklashFromRelease, OneFeedNeedsTheLatency) {
  const Given hysteresis{.value = kHysteresis_mm, .sd = 0};

  EXPECT_FALSE(BacklashFromRelease(Feeds({5}), hysteresis).backlash_mm.identifiable);
  const ReleaseFit told =
      BacklashFromRelease(Feeds({5}), hysteresis, {.value = kLatency_s, .sd = 0});
  EXPECT_TRUE(told.backlash_mm.identifiable);
  EXPECT_NEAR(told.backlash_mm.value, kBacklash_mm, 1e-9);
}

TEST(BacklashFromRelease, WithoutHysteresisOnlyTheSumIsIdentifiable) {
  const ReleaseFit fit = BacklashFromRelease(Feeds({1, 5}), kNotGiven);

  EXPECT_FALSE(fit.backlash_mm.identifiable);
  EXPECT_TRUE(fit.combination_mm.identifiable);
  EXPECT_NEAR(fit.combination_mm.value, kBacklash_mm + kHysteresis_mm, 1e-9);
  EXPECT_TRUE(fit.latency_s.identifiable);
}

TEST(BacklashFromRelease, NoReadingsTellNothing) {
  EXPECT_FALSE(BacklashFromRelease({}, {.value = kHysteresis_mm, .sd = 0.001})
                   .backlash_mm.identifiable);
}

TEST(BacklashFromRelease, CovarianceIsTheScatterOfRepeats) {
  constexpr int kRepeats = 2000;
  constexpr double kSd_mm = 0.001;
  Rng rng(13, 0, "release");
  double squares = 0;
  double stated = 0;

  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    std::vector<TriggerRelease> readings = Feeds({1, 3, 5}, kSd_mm);
    for (TriggerRelease& reading : readings) {
      reading.difference_mm.value += kSd_mm * rng.Normal();
    }
    const Given hysteresis{kHysteresis_mm + 0.0005 * rng.Normal(), 0.0005};
    const Uncertain b = BacklashFromRelease(readings, hysteresis).backlash_mm;
    squares += std::pow(b.value - kBacklash_mm, 2);
    stated += b.sd * b.sd;
  }

  EXPECT_NEAR(squares / stated, 1, 4 * std::sqrt(2.0 / kRepeats));
}

TEST(FrictionHoldsCarriage, WeighsStylusAndHangingLoadAgainstTheRail) {
  AxisDrawing axis{.moving_mass_kg = 2, .rail_friction_n = 1};
  const ProbeDrawing probe{.pretravel_mm = 0.02, .stiffness_n_per_mm = 15};  // 0.3 N

  EXPECT_TRUE(FrictionHoldsCarriage(Axis::kX, axis, probe));
  EXPECT_FALSE(FrictionHoldsCarriage(Axis::kZ, axis, probe));  // 19.6 N hang on it
  axis.counterbalance_n = 2 * kGravity_m_s2;
  EXPECT_TRUE(FrictionHoldsCarriage(Axis::kZ, axis, probe));
  axis.rail_friction_n = 0.2;
  EXPECT_FALSE(FrictionHoldsCarriage(Axis::kX, axis, probe));
}

TEST(BacklashFromApproaches, MovingInPlusTheCarriageLags) {
  // About 7.3: in + it stands b / 2 short of it, in - b / 2 beyond.
  const std::array plus{7.275, 7.275};
  const std::array minus{7.325, 7.325, 7.325};

  const Uncertain b = BacklashFromApproaches(plus, minus, 0.003);

  EXPECT_NEAR(b.value, 0.05, 1e-12);
  EXPECT_NEAR(b.sd, 0.003 * std::sqrt(1.0 / 2 + 1.0 / 3), 1e-12);
  EXPECT_FALSE(BacklashFromApproaches(plus, {}, 0.003).identifiable);
}

TEST(BacklashFromDial, ReadsTheGapInEitherSense) {
  EXPECT_NEAR(BacklashFromDial(std::array{0.05, 0.05}, +1, 0.001).value, 0.05, 1e-12);
  EXPECT_NEAR(BacklashFromDial(std::array{-0.05, -0.05}, -1, 0.001).value, 0.05, 1e-12);
}

TEST(BacklashFromDial, ZeroingCountsAsAReading) {
  constexpr int kRepeats = 4000;
  constexpr double kSd_mm = 0.001;
  Rng rng(17, 0, "dial");
  double squares = 0;

  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    const double zero_mm = kSd_mm * rng.Normal();
    const double reading_mm = kBacklash_mm + kSd_mm * rng.Normal() - zero_mm;
    squares += std::pow(
        BacklashFromDial(std::array{reading_mm}, 1, kSd_mm).value - kBacklash_mm, 2);
  }

  const double stated = BacklashFromDial(std::array{0.0}, 1, kSd_mm).sd;
  EXPECT_NEAR(squares / kRepeats / (stated * stated), 1, 4 * std::sqrt(2.0 / kRepeats));
}

TEST(Uninformative, SameSideAndAwayReturnReadZeroForEveryBacklashAndSaySo) {
  for (const double b_mm : {0.0, 0.05, 0.20}) {
    const double touch_mm = 10 + b_mm / 2;  // both times in the same sense
    const Uninformative same = SameSideBacklash(
        std::array{touch_mm}, std::array{touch_mm}, {.sigma_mm = 0.001});
    const Uninformative away = AwayReturnBacklash(std::array{0.0}, 0.001);

    for (const Uninformative& reading : {same, away}) {
      EXPECT_DOUBLE_EQ(reading.value_mm, 0);
      EXPECT_DOUBLE_EQ(reading.sensitivity, 0);
      EXPECT_FALSE(reading.backlash_mm.identifiable);
      EXPECT_FALSE(reading.statement.empty());
    }
  }
}

}  // namespace
}  // namespace caltwin

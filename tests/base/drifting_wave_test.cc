// A wave that drifts, against the one that was drawn.

#include "sim/base/drifting_wave.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "sim/base/rng.h"

namespace caltwin {
namespace {

struct Drawn {
  Eigen::VectorXd at{}, values{};
};

// Places 0.1 apart along 40; the period swings by `swing` about 0.42, the size by 30 %
// about 30.
Drawn Wave(double swing, double noise) {
  constexpr int kPlaces = 401;
  constexpr double kPeriod = 0.42, kSize = 30;
  Rng rng(3, 0, "drifting_wave_test");
  Drawn drawn{Eigen::VectorXd(kPlaces), Eigen::VectorXd(kPlaces)};
  double phase = 0;
  for (int i = 0; i < kPlaces; ++i) {
    const double at = 0.1 * i;
    phase += 2 * std::numbers::pi * 0.1 / (kPeriod * (1 + swing * std::sin(at / 9)));
    drawn.at[i] = at;
    drawn.values[i] = kSize * (1 + 0.3 * std::sin(at / 7)) * std::sin(phase) +
                      0.5 * at + noise * rng.Normal();
  }
  return drawn;
}

TEST(DriftingWave, IsFoundWithTheRangeOfItsPeriodAndSize) {
  const Drawn drawn = Wave(/*swing=*/0.04, /*noise=*/2);
  const auto wave = DriftingWaveOf(drawn.at, drawn.values);
  ASSERT_TRUE(wave);
  EXPECT_NEAR(wave->period, 0.42, 0.02);
  EXPECT_NEAR(wave->least_period, 0.42 * 0.96, 0.01);
  EXPECT_NEAR(wave->most_period, 0.42 * 1.04, 0.01);
  EXPECT_NEAR(wave->least_size, 21, 3);
  EXPECT_NEAR(wave->most_size, 39, 3);
  EXPECT_GT(wave->share, 0.95);
  EXPECT_LT(wave->share_of_fixed, 0.8);
}

TEST(DriftingWave, OfOnePeriodIsNone) {
  const Drawn drawn = Wave(/*swing=*/0, /*noise=*/2);
  EXPECT_FALSE(DriftingWaveOf(drawn.at, drawn.values));
}

TEST(DriftingWave, OfNoiseOrASmoothBendOrFewPlacesIsNone) {
  Drawn drawn = Wave(/*swing=*/0.04, /*noise=*/300);
  EXPECT_FALSE(DriftingWaveOf(drawn.at, drawn.values));
  drawn.values = (drawn.at.array() / 12).sin();
  EXPECT_FALSE(DriftingWaveOf(drawn.at, drawn.values));
  EXPECT_FALSE(DriftingWaveOf(drawn.at.head(30), drawn.values.head(30)));
}

TEST(DriftingWave, TwoThatBeatAreNone) {
  const Drawn drawn = Wave(/*swing=*/0, /*noise=*/0);
  const Eigen::ArrayXd phase = 2 * std::numbers::pi * drawn.at.array();
  Rng rng(7, 0, "drifting_wave_test");
  Eigen::VectorXd values = 20 * (phase / 0.62).sin() + 20 * (phase / 0.7).sin();
  for (double& value : values) value += 2 * rng.Normal();
  EXPECT_FALSE(DriftingWaveOf(drawn.at, values));
}

TEST(DriftingWave, OfNothingIsNone) {
  const Drawn drawn = Wave(/*swing=*/0.04, /*noise=*/0);
  const Eigen::VectorXd nothing = Eigen::VectorXd::Zero(drawn.at.size());
  EXPECT_FALSE(DriftingWaveOf(drawn.at, nothing));
}

}  // namespace
}  // namespace caltwin

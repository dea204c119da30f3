// The signs of what drifts with time and temperature, each worked out by hand.
#include <cmath>

#include <gtest/gtest.h>

#include "sim/effects/predict.h"

namespace caltwin {
namespace {

constexpr double kExact = 1e-12;

std::vector<Injected> With(const char* effect,
                           const char* axis,
                           std::vector<double> values) {
  return {{.effect = *FindEffect(effect), .axis = axis, .values = std::move(values)}};
}

const Vec3<double> kX(1, 0, 0);
const Vec3<double> kZ(0, 0, 1);

// Screw 1 K, frame 2 K and bed 3 K warmer than at the first reading.
const Climate& Warmer() {
  static const Climate kClimate = [] {
    Climate climate;
    for (std::size_t i = 0; i < kNumSensors; ++i) {
      climate.logs[i].Add(0, 20);
      climate.logs[i].Add(10, 21 + static_cast<double>(i));
    }
    return climate;
  }();
  return kClimate;
}

// What an effect adds to a touch of a face with outward normal n, after an hour.
double Added_mm(const std::vector<Injected>& effects,
                const Vec3<double>& n,
                bool on_table = true) {
  const At at{.q_mm = {100, 100, 10},
              .dir = -n,
              .n = n,
              .steps_per_mm = {800, 800, 800},
              .tip_radius_cfg_mm = 1,
              .feed_mm_s = 2,
              .on_table = on_table,
              .t_s = 3600,
              .climate = &Warmer()};
  return Predict_mm<double>(Machine{}, at, effects) -
         Predict_mm<double>(Machine{}, at, {});
}

TEST(SignsOfTime, AGrowingFrameLiftsTheToolSoTopsReadMinusAndLedgesPlus) {
  const auto growth = With("frame_growth", "", {20, 1800});

  const double lift_mm = 0.020 * (1 - std::exp(-2));
  EXPECT_NEAR(Added_mm(growth, kZ), -lift_mm, kExact);
  EXPECT_NEAR(Added_mm(growth, -kZ), +lift_mm, kExact);
  EXPECT_NEAR(Added_mm(growth, kX), 0, kExact);
}

TEST(SignsOfTime, AWarmFrameLiftsTheTool) {
  EXPECT_NEAR(Added_mm(With("frame_temperature", "frame", {5, 0}), kZ), -0.010, kExact);
}

TEST(SignsOfTime, AWarmBedRaisesWhatStandsOnIt) {
  const auto bed = With("frame_temperature", "bed", {5, 0});

  EXPECT_NEAR(Added_mm(bed, kZ), +0.015, kExact);
  EXPECT_NEAR(Added_mm(bed, -kZ), -0.015, kExact);
  EXPECT_NEAR(Added_mm(bed, kZ, /*on_table=*/false), 0, kExact);
}

TEST(SignsOfTime, AWarmProbeReadsMinusOnEveryFace) {
  const auto drift = With("probe_temperature", "", {3, 0});

  for (const Vec3<double>& n : {kZ, Vec3<double>(-kZ), kX, Vec3<double>(-kX)}) {
    EXPECT_NEAR(Added_mm(drift, n), -0.003, kExact);
  }
}

TEST(SignsOfTime, AWanderToPlusLiftsTheTool) {
  EXPECT_NEAR(
      Added_mm(With("random_walk", "", {2}), kZ), -0.002 * BrownianPath(3600), kExact);
}

TEST(SignsOfTime, FilesMayWriteZForWhatActsAlongZAlone) {
  for (const char* name : {"frame_growth", "probe_temperature", "random_walk"}) {
    EXPECT_EQ(AxisOf(EffectAt(*FindEffect(name)), "z"), "") << name;
  }
}

}  // namespace
}  // namespace caltwin

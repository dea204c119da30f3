#include "calibration/diagnosis/as_found.h"

#include <gtest/gtest.h>

#include "sim/effects/injected.h"
#include "sim/effects/predict.h"

namespace caltwin {
namespace {

Machine Gantry() {
  return ReadMachine("models/gantry_router/machine.yaml");
}

TEST(BuildIn, ScaleMovesTheToolByAsMuchAsItSays) {
  Machine machine = Gantry();
  machine.settings.steps_per_mm[0] = 808;
  // The line counts from the drawing: settings of 1 % too many move 1 % too far.
  constexpr double kFitted_ppm = 200;
  std::vector<Injected> effects;

  ASSERT_TRUE(BuildIn({.name = "scale.x", .unit = "ppm", .value = 1e4 + kFitted_ppm},
                      machine,
                      &effects));

  const At at{.q_mm = {250, 0, 0}, .steps_per_mm = {808, 800, 800}};
  const double before_mm = ErrorsAt<double>(machine, at, {}).motion_mm[0];
  const double after_mm = ErrorsAt<double>(machine, at, effects).motion_mm[0];
  EXPECT_NEAR(after_mm - before_mm, 250 * kFitted_ppm * 1e-6, 1e-9);
}

TEST(BuildIn, AGapGrowsWhatTheModelHasAndNeverBelowNothing) {
  const Machine machine = Gantry();
  std::vector<Injected> effects = {
      {.effect = EffectIndex<Backlash>(), .axis = "x", .values = {0.02}}};

  EXPECT_TRUE(BuildIn({.name = "backlash.x", .value = 0.01}, machine, &effects));
  EXPECT_FALSE(BuildIn({.name = "backlash.y", .value = -0.01}, machine, &effects));

  ASSERT_EQ(effects.size(), 1U);
  EXPECT_DOUBLE_EQ(effects[0].values[0], 0.03);
}

TEST(BuildIn, PlacementsAreNoPartOfAMachine) {
  const Machine machine = Gantry();
  std::vector<Injected> effects;

  EXPECT_FALSE(BuildIn({.name = "placement.plate.x", .value = 1}, machine, &effects));
  EXPECT_FALSE(BuildIn({.name = "size.ring", .value = 1}, machine, &effects));

  EXPECT_TRUE(effects.empty());
}

TEST(EffectOf, ATableIsBuiltAndAHomingIsNot) {
  const Finding table{.cause = "unknown",
                      .axis = "z",
                      .map = FreeMap{.channel = "z",
                                     .covariates = {"x"},
                                     .knots = {{0, 100, 300}},
                                     .values_um = {0, 10, 10}}};
  const Finding homings{
      .cause = "homing_scatter",
      .effect = Injected{
          .effect = EffectIndex<HomingScatter>(), .axis = "x", .values = {20}}};

  const auto built = EffectOf(table);

  EXPECT_FALSE(EffectOf(homings));
  ASSERT_TRUE(built);
  const At at{.q_mm = {50, 0, 0}};
  const std::vector<Injected> effects = {*built};
  EXPECT_DOUBLE_EQ(ErrorsAt<double>(Gantry(), at, effects).motion_mm[2], 0.005);
}

}  // namespace
}  // namespace caltwin

#include "sim/effects/map_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/effects/predict.h"

namespace caltwin {
namespace {

using ::testing::ElementsAre;

Injected Unknown(const std::string& axis, std::vector<double> values) {
  return {
      .effect = EffectIndex<UnknownMap>(), .axis = axis, .values = std::move(values)};
}

double Motion_mm(const Injected& effect, const At& at) {
  return ErrorsAt<double>(Machine{}, at, std::span(&effect, 1)).motion_mm[2];
}

TEST(MapTable, IsAPlaneBetweenKnotsOfAPlaneAndConstantOutside) {
  // 2 x + 3 t at the knots.
  const Injected effect =
      Unknown("z{x,t}", FlatMap({0, 3, 6, 20, 23, 26}, {{0, 10}, {0, 1, 2}}));

  EXPECT_DOUBLE_EQ(Motion_mm(effect, {.q_mm = {4, 0, 0}, .t_s = 1.5}), 12.5e-3);
  EXPECT_DOUBLE_EQ(Motion_mm(effect, {.q_mm = {-9, 0, 0}, .t_s = 0.5}), 1.5e-3);
  EXPECT_DOUBLE_EQ(Motion_mm(effect, {.q_mm = {99, 0, 0}, .t_s = 7}), 26e-3);
}

TEST(MapTable, WithoutValuesOrWithoutItsCovariateDoesNothing) {
  EXPECT_EQ(Motion_mm(Unknown("z{x}", {}), {}), 0);
  EXPECT_EQ(Motion_mm(Unknown("z{load}", FlatMap({1, 2}, {{0, 1}})), {}), 0);
}

TEST(MapTable, IsTakenApartAsItWasPutTogether) {
  const std::vector<double> flat = FlatMap({1, 2, 3, 4, 5, 6}, {{0, 1, 2}, {7, 8}});

  const MapTable table = TableOf(flat, 2);

  EXPECT_THAT(table.values, ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_THAT(table.knots, ElementsAre(ElementsAre(0, 1, 2), ElementsAre(7, 8)));
}

TEST(MapTable, OfAPitchFollowsItsOwnAxis) {
  const Injected effect{.effect = EffectIndex<PitchMap>(),
                        .axis = "y",
                        .values = FlatMap({0, 10, 0}, {{0, 100, 200}})};
  const At at{.q_mm = {0, 150, 0}};

  const auto errors = ErrorsAt<double>(Machine{}, at, std::span(&effect, 1));

  EXPECT_DOUBLE_EQ(errors.motion_mm[1], 5e-3);
}

TEST(MapTable, OfTheProbeAndTheBedShowInTouches) {
  const At at{.n = {0, 0, 1}, .on_table = true};
  const Injected probe = Unknown("probe", {7});
  const Injected bed = Unknown("bed", {7});
  const double plain_mm = Predict_mm<double>(Machine{}, at, {});

  EXPECT_NEAR(
      Predict_mm<double>(Machine{}, at, std::span(&probe, 1)) - plain_mm, -7e-3, 1e-12);
  EXPECT_NEAR(
      Predict_mm<double>(Machine{}, at, std::span(&bed, 1)) - plain_mm, 7e-3, 1e-12);
}

}  // namespace
}  // namespace caltwin

#include <cmath>

#include <gtest/gtest.h>

#include "calibration/estimate/deflection.h"
#include "sim/base/rng.h"

namespace caltwin {
namespace {

constexpr double kPretravel_mm = 0.02;
constexpr double kBacklash_mm = 0.05;
constexpr double kRadius_mm = 1.0;
constexpr double kRadiusCfg_mm = 1.5;
constexpr double kSize_mm = 25.4;

// Spans from the two triggers themselves, PROCEDURES "Signs".
double External_mm(double k) {
  const double in_plus = (10 - kRadius_mm + kPretravel_mm + kBacklash_mm / 2) / k;
  const double in_minus =
      (10 + kSize_mm + kRadius_mm - kPretravel_mm - kBacklash_mm / 2) / k;
  return in_minus - in_plus - 2 * kRadiusCfg_mm;
}
double Internal_mm(double k) {
  const double in_plus =
      (10 + kSize_mm - kRadius_mm + kPretravel_mm + kBacklash_mm / 2) / k;
  const double in_minus = (10 + kRadius_mm - kPretravel_mm - kBacklash_mm / 2) / k;
  return in_plus - in_minus + 2 * kRadiusCfg_mm;
}

DeflectionSpan Measured(SpanKind kind, double k) {
  return {.kind = kind,
          .size_mm = {.value = kSize_mm},
          .span_mm = {.value = kind == SpanKind::kExternal ? External_mm(k)
                                                           : Internal_mm(k)},
          .tip_radius_cfg_mm = kRadiusCfg_mm,
          .tip_radius_mm = {.value = kRadius_mm},
          .backlash_mm = {.value = kBacklash_mm},
          .mm_per_commanded_mm = {.value = k}};
}

TEST(DeflectionFromSpan, RecoversPretravelFromBlockAndBoreAtAnyScale) {
  for (const SpanKind kind : {SpanKind::kExternal, SpanKind::kInternal}) {
    for (const double k : {1.0, 1.01}) {
      EXPECT_NEAR(DeflectionFromSpan(Measured(kind, k)).pretravel_mm.value,
                  kPretravel_mm,
                  1e-12);
    }
  }
}

TEST(DeflectionFromSpan, BlockAndBoreTellTheSameCombination) {
  const double combination_mm = kPretravel_mm + kBacklash_mm / 2 - kRadius_mm;

  for (const SpanKind kind : {SpanKind::kExternal, SpanKind::kInternal}) {
    const Deflection deflection = DeflectionFromSpan(Measured(kind, 1));
    EXPECT_NEAR(deflection.combination_mm.value, combination_mm, 1e-12);
  }
}

TEST(DeflectionFromSpan, WithoutBacklashOnlyTheCombinationIsIdentifiable) {
  DeflectionSpan span = Measured(SpanKind::kExternal, 1);
  span.backlash_mm = kNotGiven;

  const Deflection deflection = DeflectionFromSpan(span);

  EXPECT_FALSE(deflection.pretravel_mm.identifiable);
  EXPECT_TRUE(deflection.combination_mm.identifiable);
}

TEST(DeflectionAsPublished, HasTheWrongSignOnABlock) {
  DeflectionSpan span = Measured(SpanKind::kExternal, 1);
  span.tip_radius_cfg_mm = kRadius_mm;
  span.span_mm.value += 2 * (kRadiusCfg_mm - kRadius_mm);

  EXPECT_NEAR(
      DeflectionAsPublished(span).value, -(kPretravel_mm + kBacklash_mm / 2), 1e-12);
}

TEST(DeflectionFromSpan, CovarianceIsTheScatterOfRepeats) {
  constexpr int kRepeats = 4000;
  Rng rng(7, 0, "deflection");
  double squares = 0;
  double stated = 0;

  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    DeflectionSpan span = Measured(SpanKind::kExternal, 1);
    const auto blur = [&](Given* given, double sd) {
      given->value += sd * rng.Normal();
      given->sd = sd;
    };
    blur(&span.size_mm, 0.002);
    blur(&span.span_mm, 0.0015);
    blur(&span.tip_radius_mm, 0.001);
    blur(&span.backlash_mm, 0.003);
    blur(&span.mm_per_commanded_mm, 5e-5);
    const Uncertain estimate = DeflectionFromSpan(span).pretravel_mm;
    squares += std::pow(estimate.value - kPretravel_mm, 2);
    stated += estimate.sd * estimate.sd;
  }

  EXPECT_NEAR(squares / stated, 1, 4 * std::sqrt(2.0 / kRepeats));
}

}  // namespace
}  // namespace caltwin

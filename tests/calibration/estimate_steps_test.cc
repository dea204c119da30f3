#include <cmath>

#include <gtest/gtest.h>

#include "calibration/estimate/steps.h"
#include "sim/base/rng.h"

namespace caltwin {
namespace {

constexpr double kTrueSteps = 800;
constexpr double kPretravel_mm = 0.02;
constexpr double kBacklash_mm = 0.05;
constexpr double kRadius_mm = 1.0;
constexpr double kRadiusCfg_mm = 1.01;

// The span a firmware configured with `steps` reports of a block of `size_mm`, from
// the two triggers themselves (PROCEDURES, "Signs"): face at 100 touched in +, the
// other in -.
double Span_mm(double steps, double size_mm) {
  const double k = steps / kTrueSteps;
  const double left_mm = (100 - kRadius_mm + kPretravel_mm + kBacklash_mm / 2) / k;
  const double right_mm =
      (100 + size_mm + kRadius_mm - kPretravel_mm - kBacklash_mm / 2) / k;
  return right_mm - left_mm - 2 * kRadiusCfg_mm;
}

TwoSpans Block(double steps) {
  return {.steps_per_mm = steps,
          .size1_mm = {.value = 25.4},
          .size2_mm = {.value = 76.2},
          .span1_mm = {.value = Span_mm(steps, 25.4)},
          .span2_mm = {.value = Span_mm(steps, 76.2)}};
}

TEST(StepsFromTwoSpans, RecoversTheTruthInOnePassWhateverProbeAndBacklash) {
  for (const double steps : {760.0, 808.0, 840.0}) {
    EXPECT_NEAR(StepsFromTwoSpans(Block(steps)).value, kTrueSteps, 1e-9);
  }
}

TEST(StepsFromTwoSpansAsPublished, DoublesTheErrorEachPass) {
  // s / 800 squares at each pass: 808 = 800 * 1.01 -> 816.08 -> 832.48 -> 866.28.
  double steps = 808;
  for (const double expected : {1.01 * 1.01, std::pow(1.01, 4), std::pow(1.01, 8)}) {
    steps = StepsFromTwoSpansAsPublished(Block(steps)).value;
    EXPECT_NEAR(steps, 800 * expected, 1e-6);
  }
}

TEST(StepsFromTwoSpans, CovarianceIsTheScatterOfRepeats) {
  constexpr int kRepeats = 4000;
  constexpr double kSd_mm = 0.002;
  Rng rng(5, 0, "two_spans");
  TwoSpans spans = Block(808);
  double squares = 0;
  double stated = 0;

  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    spans.span1_mm = {Span_mm(808, 25.4) + kSd_mm * rng.Normal(), kSd_mm};
    spans.span2_mm = {Span_mm(808, 76.2) + kSd_mm * rng.Normal(), kSd_mm};
    spans.size1_mm = {25.4 + kSd_mm * rng.Normal(), kSd_mm};
    spans.size2_mm = {76.2 + kSd_mm * rng.Normal(), kSd_mm};
    const Uncertain estimate = StepsFromTwoSpans(spans);
    squares += std::pow(estimate.value - kTrueSteps, 2);
    stated += estimate.sd * estimate.sd;
  }

  EXPECT_NEAR(squares / stated, 1, 4 * std::sqrt(2.0 / kRepeats));
}

TEST(StepsFromTwoSpans, OneSizeTwiceIsNotIdentifiable) {
  TwoSpans spans = Block(808);
  spans.size2_mm = spans.size1_mm;
  spans.span2_mm = spans.span1_mm;

  EXPECT_FALSE(StepsFromTwoSpans(spans).identifiable);
}

OneSpan Single(double steps) {
  return {.steps_per_mm = steps,
          .size_mm = {.value = 25.4},
          .span_mm = {.value = Span_mm(steps, 25.4)},
          .tip_radius_cfg_mm = kRadiusCfg_mm,
          .tip_radius_mm = {.value = kRadius_mm},
          .pretravel_mm = {.value = kPretravel_mm},
          .backlash_mm = {.value = kBacklash_mm}};
}

TEST(StepsFromOneSpan, RecoversTheTruthWherePretravelBacklashAndTipAreKnown) {
  EXPECT_NEAR(StepsFromOneSpan(Single(808)).value, kTrueSteps, 1e-9);
}

TEST(StepsFromOneSpan, UnknownBacklashIsNotIdentifiable) {
  OneSpan span = Single(808);
  span.backlash_mm = kNotGiven;

  EXPECT_FALSE(StepsFromOneSpan(span).identifiable);
}

TEST(StepsFromOneSpan, UncertainPretravelCountsTwice) {
  OneSpan span = Single(800);
  span.pretravel_mm.sd = 0.003;

  // d s / d delta = 2 s / (tip centres' distance).
  const double centres_mm = 25.4 + 2 * kRadius_mm - 2 * kPretravel_mm - kBacklash_mm;
  EXPECT_NEAR(StepsFromOneSpan(span).sd, 2 * 0.003 * 800 / centres_mm, 1e-9);
}

TEST(StepsFromOneSpanAsPublished, MovesAwayFromTheTruth) {
  EXPECT_GT(StepsFromOneSpanAsPublished(Single(808)).value, 808 + 5);
}

TEST(StepsFromMove, RecoversTheTruth) {
  // 808 configured, 800 true: 100 mm commanded go 101 mm.
  const Uncertain steps = StepsFromMove({.steps_per_mm = 808,
                                         .commanded_mm = 100,
                                         .actual_mm = {.value = 101, .sd = 0.05}});

  EXPECT_NEAR(steps.value, 800, 1e-9);
  EXPECT_NEAR(steps.sd, 800 * 0.05 / 101, 1e-9);
}

TEST(StepsFromMove, NoMoveIsNotIdentifiable) {
  EXPECT_FALSE(StepsFromMove({.steps_per_mm = 800,
                              .commanded_mm = 0,
                              .actual_mm = {.value = 0, .sd = 0.05}})
                   .identifiable);
}

}  // namespace
}  // namespace caltwin

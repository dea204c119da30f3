// Correlations by shared inputs are those of the sums they are made of.

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "calibration/estimate/deflection.h"
#include "calibration/estimate/shared_inputs.h"
#include "calibration/estimate/steps.h"

namespace caltwin {
namespace {

double R(const Correlations& of, const std::string& a, const std::string& b) {
  const auto at = [&](const std::string& name) {
    return std::ranges::find(of.names, name) - of.names.begin();
  };
  return of.matrix(at(a), at(b));
}

// p = t + e1, q = -t + e2, u(t) = 3, u(e1) = 4, u(e2) = 0: r = -9 / (5 * 3).
TEST(SharedInputs, GoTogetherByWhatTheyShare) {
  const std::vector<Budgeted> results = {
      {.name = "p", .budget = {{.u = 3, .source = "t"}, {.u = 4}}},
      {.name = "q", .budget = {{.u = 3, .source = "t", .sense = -1}}},
      {.name = "alone", .budget = {{.u = 7}}}};
  const Correlations of = SharedCorrelations(results, {});

  EXPECT_EQ(of.names, (std::vector<std::string>{"p", "q"}));
  EXPECT_NEAR(R(of, "p", "q"), -0.6, 1e-12);
}

// b = h + e, u 3 and 4; d = b / 2 + h / 2 + f, so h has 3 / 2 + 3 / 2, e 2, f 6: the
// covariance with b is 3 * 3 + 2 * 4. The order in which they are told does not matter.
TEST(SharedInputs, AResultBringsAlongWhatItStandsOn) {
  const Budgeted gap{.name = "b", .budget = {{.u = 3, .source = "h"}, {.u = 4}}};
  const Budgeted depth{
      .name = "d",
      .budget = {{.u = 2.5, .source = "b"}, {.u = 1.5, .source = "h"}, {.u = 6}}};
  const double expected = (3 * 3 + 2 * 4) / (5 * std::sqrt(3 * 3 + 2 * 2 + 6 * 6));

  for (const auto& results : {std::vector{gap, depth}, std::vector{depth, gap}}) {
    EXPECT_NEAR(R(SharedCorrelations(results, {}), "b", "d"), expected, 1e-12);
  }
}

TEST(SharedInputs, WhatWasMeasuredInTurnsEnds) {
  const std::vector<Budgeted> results = {
      {.name = "b", .budget = {{.u = 3, .source = "d"}, {.u = 4}}},
      {.name = "d", .budget = {{.u = 1, .source = "b"}, {.u = 2}}}};
  const Correlations of = SharedCorrelations(results, {});

  ASSERT_EQ(of.names.size(), 2U);
  EXPECT_GT(R(of, "b", "d"), 0);
  EXPECT_LT(R(of, "b", "d"), 1);
}

TEST(SharedInputs, WhatOneFitToldStands) {
  const std::vector<Budgeted> results = {
      {.name = "p", .budget = {{.u = 3, .source = "t"}, {.u = 4}}},
      {.name = "q", .budget = {{.u = 3, .source = "t"}}}};
  const std::vector<Correlations> fits = {
      {.procedure = "fit",
       .names = {"q", "p"},
       .matrix = Eigen::Matrix2d{{1, -0.25}, {-0.25, 1}}}};

  EXPECT_EQ(R(SharedCorrelations(results, fits), "p", "q"), -0.25);
}

// Of two axes deflections share the ball; of one, steps/mm by two sizes and the
// deflection by the first of them share that size. Against differences of the formulas.
TEST(SharedInputs, OfDeflectionAndStepsAreThoseOfTheirFormulas) {
  const Given size1{.value = 25.4, .sd = 0.003, .source = "one"};
  const Given size2{.value = 76.2, .sd = 0.004, .source = "two"};
  const auto steps = [&](double off1_mm) {
    return StepsFromTwoSpans(
        {.steps_per_mm = 800,
         .size1_mm = {.value = size1.value + off1_mm, .sd = size1.sd, .source = "one"},
         .size2_mm = size2,
         .span1_mm = {.value = 20.1, .sd = 0.001},
         .span2_mm = {.value = 70.9, .sd = 0.001}});
  };
  const auto deflection = [&](double off1_mm) {
    return DeflectionFromSpan(
               {.kind = SpanKind::kExternal,
                .size_mm = {.value = size1.value + off1_mm,
                            .sd = size1.sd,
                            .source = "one"},
                .span_mm = {.value = 20.1, .sd = 0.001},
                .tip_radius_cfg_mm = 2,
                .tip_radius_mm = {.value = 2, .sd = 0.001, .source = "t"},
                .backlash_mm = {.value = 0, .sd = 0.0005},
                .mm_per_commanded_mm = {.value = 1}})
        .pretravel_mm;
  };
  const double by_steps = (steps(0.1).value - steps(0).value) / 0.1;
  const double by_deflection = (deflection(0.1).value - deflection(0).value) / 0.1;
  const double expected =
      by_steps * by_deflection * size1.sd * size1.sd / (steps(0).sd * deflection(0).sd);

  const std::vector<Budgeted> results = {
      {.name = "steps", .budget = steps(0).budget},
      {.name = "deflection", .budget = deflection(0).budget}};
  EXPECT_GT(std::abs(expected), 0.2);
  EXPECT_NEAR(R(SharedCorrelations(results, {}), "steps", "deflection"),
              expected,
              0.02 * std::abs(expected));
}

}  // namespace
}  // namespace caltwin

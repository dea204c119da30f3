#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/procedures/joint_estimate.h"
#include "calibration/procedures/next_all.h"
#include "calibration/procedures/plane_tilt.h"
#include "calibration/procedures/verify.h"
#include "tests/calibration/toy_bench.h"

namespace caltwin {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::RunStep;
using testing::ToyBench;

constexpr double kStep_mm = 1 / 800.0;

void Spoil(ToyBench* toy) {
  toy->machine.settings.steps_per_mm = {808, 795, 806};
  toy->machine.drives[0] = {.gap_mm = 0.05, .pretravel_mm = 0.025};
  toy->machine.drives[1] = {.gap_mm = 0.08, .pretravel_mm = 0.018};
  toy->machine.drives[2] = {.gap_mm = 0.03};
}

const Estimate& Last(const ProcedureResult& result, const std::string& name) {
  const Estimate* last = nullptr;
  for (const Estimate& estimate : result.estimates) {
    if (estimate.name == name) last = &estimate;
  }
  if (last == nullptr) throw std::runtime_error("no estimate of " + name);
  return *last;
}

TEST(JointEstimate, FindsEverythingButThePretravelOfZ) {
  ToyBench toy;
  Spoil(&toy);

  const ProcedureResult result =
      RunStep(kJointEstimate, "{tip_radius_mm: 1, tip_radius_u_mm: 0.0001}", &toy);

  EXPECT_EQ(result.ending, Ending::kDone);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(toy.machine.settings.steps_per_mm[i], 800, 0.05) << i;
    EXPECT_NEAR(
        toy.machine.settings.backlash_mm[i], toy.machine.drives[i].gap_mm, 2 * kStep_mm)
        << i;
  }
  EXPECT_NEAR(Last(result, "probe_pretravel.x").value, 0.025, 2 * kStep_mm);
  EXPECT_NEAR(Last(result, "probe_pretravel.y").value, 0.018, 2 * kStep_mm);
  EXPECT_FALSE(Last(result, "probe_pretravel.z").identifiable);
  EXPECT_NEAR(Last(result, "bed_tilt.slope_x_mrad").value, 0, 0.01);
}

// One matrix over everything told. Touches know pre-travel less the tip, so an error of
// the tip's radius is one of every pre-travel: they go up and down together.
TEST(JointEstimate, StatesHowErrorsGoTogether) {
  ToyBench toy;
  Spoil(&toy);

  const ProcedureResult result =
      RunStep(kJointEstimate, "{tip_radius_mm: 1, tip_radius_u_mm: 0.001}", &toy);

  ASSERT_EQ(result.correlations.size(), 1U);
  const Correlations& of = result.correlations[0];
  const auto at = [&](const std::string& name) {
    return std::ranges::find(of.names, name) - of.names.begin();
  };
  ASSERT_EQ(of.matrix.rows(), std::ssize(of.names));
  EXPECT_THAT(of.names, ::testing::Not(Contains("probe_pretravel.z")));
  const double r = of.matrix(at("probe_pretravel.x"), at("probe_pretravel.y"));
  // u^2 of the tip over those of both.
  const double tip = 0.001, x = Last(result, "probe_pretravel.x").sd,
               y = Last(result, "probe_pretravel.y").sd;
  EXPECT_GT(r, 0.5);
  EXPECT_LT(std::abs(r - tip * tip / (x * y)), 0.15);
  // Nothing ties the steps of two axes but the delay of the trigger that both share.
  const Eigen::Index late = at("trigger_latency");
  const double by_delay =
      of.matrix(at("steps_per_mm.x"), late) * of.matrix(at("steps_per_mm.y"), late);
  EXPECT_GT(by_delay, 0.01);
  EXPECT_NEAR(of.matrix(at("steps_per_mm.x"), at("steps_per_mm.y")), by_delay, 0.01);
}

TEST(JointEstimate, LeavesCompensationAsItWasWhereNothingIsApplied) {
  ToyBench toy;
  toy.machine.settings.backlash_mm = {0.01, 0.02, 0.03};

  RunStep(kJointEstimate, "{axis: x, apply: false, tilt: false}", &toy);

  EXPECT_THAT(toy.machine.settings.backlash_mm, ElementsAre(0.01, 0.02, 0.03));
}

TEST(NextAll, CalibratesThreeAxesInEitherOrderAndKeepsThem) {
  for (const char* order : {"section_2", "appendix_a"}) {
    ToyBench toy;
    Spoil(&toy);

    const ProcedureResult result =
        RunStep(kNextAll, fmt::format("{{date: 2026-11-21, order: {}}}", order), &toy);

    EXPECT_EQ(result.ending, Ending::kDone) << result.fault;
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(toy.machine.settings.steps_per_mm[i], 800, 0.05) << order << i;
      EXPECT_NEAR(toy.machine.settings.backlash_mm[i],
                  toy.machine.drives[i].gap_mm,
                  2 * kStep_mm)
          << order << i;
    }
    EXPECT_NEAR(Last(result, "probe_pretravel.x").value, 0.025, 3 * kStep_mm);
    EXPECT_FALSE(Last(result, "probe_pretravel.z").identifiable);
    EXPECT_THAT(toy.machine.written, Contains("; Last calibrated: 2026-11-21"));
    EXPECT_THAT(toy.machine.written, Contains(HasSubstr("M92 X")));
  }
}

TEST(NextAll, TenRunsDriftByLessThanAMicrometre) {
  ToyBench toy;
  Spoil(&toy);
  const std::string options = "{axes: [x], persist: false, verify: false}";

  RunStep(kNextAll, options, &toy);
  const Settings first = toy.machine.settings;
  for (int i = 0; i < 9; ++i) RunStep(kNextAll, options, &toy);

  const double drift_mm =
      300 * (toy.machine.settings.steps_per_mm[0] / first.steps_per_mm[0] - 1);
  EXPECT_LT(std::abs(toy.machine.settings.backlash_mm[0] - first.backlash_mm[0]),
            0.001);
  EXPECT_LT(std::abs(drift_mm), 0.001);
}

TEST(Verify, NamesTheCalibrationToRevisit) {
  EXPECT_THAT(WhatToRevisit(Axis::kX, {}), IsEmpty());
  EXPECT_THAT(WhatToRevisit(Axis::kX, {.slope = 0.001}),
              ElementsAre(HasSubstr("revisit steps/mm")));
  EXPECT_THAT(
      WhatToRevisit(Axis::kX,
                    {.reversal_mm = 0.05, .reversal_known = true, .offset_mm = -0.05}),
      ElementsAre(HasSubstr("revisit the backlash")));
  EXPECT_THAT(WhatToRevisit(Axis::kX, {.reversal_known = true, .offset_mm = -0.04}),
              ElementsAre(HasSubstr("revisit the probe's deflection")));
  EXPECT_THAT(WhatToRevisit(Axis::kX, {.scatter_mm = 0.008}),
              ElementsAre(HasSubstr("mechanics")));
}

TEST(Verify, SeesEachErrorOnTheMachine) {
  struct Case {
    double steps, gap, pretravel;
    const char* words;
  };
  for (const Case& c : {Case{801, 0, 0, "revisit steps/mm"},
                        Case{800, 0.05, 0, "revisit the backlash"},
                        Case{800, 0, 0.03, "revisit the probe's deflection"}}) {
    ToyBench toy;
    toy.machine.settings.steps_per_mm[0] = c.steps;
    toy.machine.drives[0] = {.gap_mm = c.gap, .pretravel_mm = c.pretravel};

    const ProcedureResult result = RunStep(kVerify, "{axis: x}", &toy);

    EXPECT_THAT(result.messages, Contains(HasSubstr(c.words)));
    EXPECT_THAT(result.messages.back(), HasSubstr(c.words));
  }
}

TEST(PlaneTilt, OfATableThatRisesTowardsXIsItsSlopeAlongXAlone) {
  ToyBench toy;
  toy.machine.table_slope_x = 0.001;

  const ProcedureResult result = RunStep(kPlaneTilt, "{grid: [4, 3]}", &toy);

  // Half a motor step at one end of the grid, 260 mm from the other.
  const double from_rounding_mrad = 1000 * kStep_mm / 260;
  EXPECT_NEAR(Last(result, "bed_tilt.slope_x_mrad").value, 1, from_rounding_mrad);
  EXPECT_NEAR(Last(result, "bed_tilt.slope_y_mrad").value, 0, from_rounding_mrad);
}

TEST(PlaneTilt, OfALevelTableIsZero) {
  ToyBench toy;

  const ProcedureResult result = RunStep(kPlaneTilt, "{grid: [4, 3]}", &toy);

  EXPECT_EQ(result.ending, Ending::kDone);
  EXPECT_NEAR(Last(result, "bed_tilt.slope_x_mrad").value, 0, 1e-9);
  EXPECT_GT(Last(result, "bed_tilt.slope_y_mrad").sd, 0);
}

}  // namespace
}  // namespace caltwin

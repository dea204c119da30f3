#include "calibration/diagnosis/volumetric.h"

#include <cmath>

#include <gtest/gtest.h>

#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kGap_mm = 0.02, kSet_per_mm = 808;
constexpr double kTooMany_ppm = 1e4;  // 808 on a screw of 800.

Machine Gantry() {
  return ReadMachine("models/gantry_router/machine.yaml");
}

// Rows that were measured with 1 % more steps/mm than the drawing's, as machine and
// header both say.
Observed SetOtherwise() {
  RowTable table;
  for (int i = 0; i < 4; ++i) {
    Row row{.row = i + 1, .campaign = "laser", .settings = "s1"};
    row.n = {1, 0, 0};
    row.cmd_mm = {10.0 + 50 * i, 100, 50};
    row.dir = {1, 1, 1};
    row.value_mm = 0;
    table.rows.push_back(row);
  }
  DataHeader header;
  header.settings["s1"].steps_per_mm["x"] = kSet_per_mm;
  Machine machine = Gantry();
  machine.settings.steps_per_mm[0] = kSet_per_mm;
  return {table, header, machine, {}};
}

// A gap in y was found, and this of x's scale.
Diagnosis Found(double scale_ppm) {
  Diagnosis diagnosis;
  diagnosis.baseline = {
      {.name = "scale.x", .unit = "ppm", .value = scale_ppm, .sd = 1}};
  diagnosis.findings = {
      {.cause = "backlash",
       .axis = "y",
       .effect = Injected{
           .effect = EffectIndex<Backlash>(), .axis = "y", .values = {kGap_mm}}}};
  return diagnosis;
}

TEST(VolumetricGain, WrongStepsAreAnErrorOverTheWholeTravel) {
  const auto gain = VolumetricGainOf(SetOtherwise(), Found(kTooMany_ppm), 1);

  ASSERT_TRUE(gain);
  // Evenly over the travel: its length over the root of twelve. 300 poses tell that to
  // a few percent.
  const double rms_mm = FractionFromPpm(kTooMany_ppm) *
                        Gantry().axis(Axis::kX).travel_mm() / std::sqrt(12.0);
  EXPECT_NEAR(gain->before_mm, rms_mm, 0.1 * rms_mm);
  EXPECT_NEAR(gain->findings_mm, kGap_mm / 2, 0.001);
  EXPECT_LT(gain->after_mm, 1e-3 * rms_mm);
}

// Built with the screw it is set for: nothing is off but the gap, half of it each way.
TEST(VolumetricGain, StepsThatFitTheMachineAreNone) {
  const auto gain = VolumetricGainOf(SetOtherwise(), Found(0), 1);

  ASSERT_TRUE(gain);
  EXPECT_NEAR(gain->before_mm, kGap_mm / 2, 0.001);
}

// What rows leave open has no sd that could move the tool.
TEST(VolumetricGain, CountsNoLineThatIsNotDetermined) {
  Diagnosis diagnosis = Found(kTooMany_ppm + 500);
  diagnosis.baseline[0].sd = kUnknown;
  const auto gain = VolumetricGainOf(SetOtherwise(), diagnosis, 1);

  ASSERT_TRUE(gain);
  EXPECT_TRUE(std::isfinite(gain->after_mm));
}

}  // namespace
}  // namespace caltwin

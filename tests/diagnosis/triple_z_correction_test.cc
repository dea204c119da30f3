// What a correction tells a controller is obeyed by one, and levels the bed.
#include "calibration/diagnosis/kinds/triple_z_correction.h"

#include <sstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/diagnosis/correction.h"
#include "sim/base/input_error.h"
#include "sim/kinds/triple_z/plant.h"
#include "sim/machine/kinds/triple_z/drawing.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kSlopeX_mrad = 3, kSlopeY_mrad = -2;

Machine DrawnPrinter() {
  return ReadMachine(CALTWIN_SOURCE_DIR "/models/triple_z_printer/machine.yaml");
}

Observed OneTouch() {
  Row row{.kind = RowKind::kTouch, .setup = "bed"};
  row.cmd_mm = {20, 20, 0};
  row.motor_mm.fill(250);
  row.n = {0, 0, 1};
  row.feature = "bed.top";
  return {{.rows = {row}}, {}, DrawnPrinter(), {}};
}

// A tilted bed with these effects, found as they are.
Diagnosis AnswerThatFinds(const std::vector<Injected>& effects) {
  Diagnosis diagnosis;
  diagnosis.baseline = {{"scale.z", "ppm", 0, 10},
                        {"backlash.z", "mm", 0, 0.001},
                        {"bed_plane.slope_x", "mrad", kSlopeX_mrad, 0.01},
                        {"bed_plane.slope_y", "mrad", kSlopeY_mrad, 0.01}};
  for (const Injected& effect : effects) {
    diagnosis.findings.push_back({.cause = std::string(EffectAt(effect.effect).name),
                                  .axis = effect.axis,
                                  .effect = effect});
  }
  return diagnosis;
}

// The printer that is so, levelled once by its firmware after it read the correction:
// how far screws' corners are from level.
double LeftOf_mm(const std::vector<Injected>& effects, const std::string& correction) {
  BuiltTripleZ built{.machine = DrawnPrinter(), .effects = effects};
  built.effects.push_back({.effect = EffectIndex<BedTilt>(),
                           .axis = "",
                           .values = {kSlopeX_mrad, kSlopeY_mrad}});
  TripleZTwinPlant plant(built, /*is_physics=*/false, 1, 0);
  Firmware firmware(built.machine,
                    built.machine.settings,
                    FirmwareOnScrews(TripleZOf(built.machine).pivots_mm()),
                    &plant);
  std::istringstream lines(correction +
                           "G28\nG30 P0 X20 Y20 Z-99999\nG30 P1 X215 Y20 Z-99999\n"
                           "G30 P2 X20 Y215 Z-99999 S3\n");
  for (std::string line; std::getline(lines, line);) {
    const Reply reply = firmware.Execute(line.substr(0, line.find(';')));
    EXPECT_FALSE(reply.error) << line;
  }
  double left_mm = 0;
  for (const Eigen::Vector2d& at_mm : TripleZOf(built.machine).pivots_mm()) {
    left_mm = std::max(left_mm,
                       std::abs(TrueBedHeight_mm(built, firmware.raised_mm(), at_mm)));
  }
  return left_mm;
}

Injected Wired(std::string_view wiring) {
  return {.effect = EffectIndex<MotorsSwapped>(),
          .axis = std::string(wiring),
          .values = {1}};
}

// A screw's step is 1.25 um; outside the triangle of the screws it counts for more.
constexpr double kSteps_mm = 0.004;

TEST(TripleZCorrection, LevelsInOneRoundWhateverTheWiring) {
  for (const std::string_view wiring : MotorsSwapped::kWirings) {
    SCOPED_TRACE(wiring);
    const std::vector<Injected> effects = {
        Wired(wiring),
        {.effect = EffectIndex<PivotPosition>(), .axis = "z2", .values = {-25, 18}}};
    const std::string text = TripleZCorrectionText(
        ControllerKind::kRrf, AnswerThatFinds(effects), OneTouch());

    EXPECT_GT(LeftOf_mm(effects, ""), 0.1);
    EXPECT_LT(LeftOf_mm(effects, text), kSteps_mm) << text;
  }
}

// Guides that leave a fifth of a tilt: where screws seem to stand it is exact.
TEST(TripleZCorrection, LevelsABedThatGuidesHold) {
  const std::vector<Injected> effects = {
      {.effect = EffectIndex<OverconstrainedBed>(), .axis = "", .values = {3000}},
      {.effect = EffectIndex<PivotPosition>(), .axis = "z3", .values = {10, -15}}};
  const std::string text =
      TripleZCorrectionText(ControllerKind::kRrf, AnswerThatFinds(effects), OneTouch());

  EXPECT_GT(LeftOf_mm(effects, ""), 0.02);
  EXPECT_LT(LeftOf_mm(effects, text), kSteps_mm) << text;
}

// By hand: a pitch of 500 ppm lifts screw 3 by 0.125 mm at 250 mm, beside the plane
// that takes screw 2 up by 0.585 and screw 3 down by 0.39. Less their mean.
TEST(TripleZCorrection, SaysHowFarEachScrewIsToBeRaised) {
  const std::vector<Injected> effects = {
      {.effect = EffectIndex<ScrewPitch>(), .axis = "z3", .values = {500}}};
  const std::string text =
      TripleZCorrectionText(ControllerKind::kRrf, AnswerThatFinds(effects), OneTouch());

  const double mean_mm = (0.585 - 0.39 + 0.125) / 3;
  EXPECT_THAT(text, HasSubstr(fmt::format("raises z1 {:+.3f} +- 0.001 mm", mean_mm)));
  EXPECT_THAT(text, HasSubstr(fmt::format("z2 {:+.3f}", mean_mm - 0.585)));
  EXPECT_THAT(text, HasSubstr(fmt::format("z3 {:+.3f}", mean_mm + 0.39 - 0.125)));
  EXPECT_THAT(text, HasSubstr("nothing to set"));
  EXPECT_THAT(text, HasSubstr("no line for RepRapFirmware is written for this"));
}

TEST(TripleZCorrection, SpeaksEachControllersWords) {
  const std::vector<Injected> effects = {
      Wired("z1z2z3"),
      {.effect = EffectIndex<ScrewPitch>(), .axis = "z2", .values = {1000}}};
  Diagnosis found = AnswerThatFinds(effects);
  found.baseline[0] = {"scale.z", "ppm", 2000, 10};
  found.baseline[1] = {"backlash.z", "mm", 0.05, 0.001};
  const auto text = [&](ControllerKind controller) {
    return CorrectionFor(controller, found, OneTouch(), "fix").at(0).text;
  };

  // Driver 1 turns screw 2 at (215, 20), driver 2 screw 3, driver 3 screw 1.
  const std::string rrf = text(ControllerKind::kRrf);
  EXPECT_THAT(rrf, HasSubstr("M671 X215.00:20.00:20.00 Y20.00:215.00:20.00\n"));
  EXPECT_THAT(rrf,
              HasSubstr("; or plug the motors in as drawn, and then "
                        "X20.00:215.00:20.00 Y20.00:20.00:215.00\n"));
  EXPECT_THAT(rrf, HasSubstr("M92 Z798.4032 ; steps/mm, was 800: scale.z "));
  EXPECT_THAT(rrf, HasSubstr("M425 Z0.0500 ; mm, backlash.z "));
  EXPECT_THAT(text(ControllerKind::kMarlin),
              HasSubstr("M422 W1 X215.00 Y20.00\nM422 W2 X20.00 Y215.00\n"
                        "M422 W3 X20.00 Y20.00\n"));
  const std::string klipper = text(ControllerKind::kKlipper);
  EXPECT_THAT(klipper,
              HasSubstr("[z_tilt]\nz_positions:\n    215.00, 20.00\n    20.00, "
                        "215.00\n    20.00, 20.00\n"));
  // 4 mm a turn, times 1.002, of screw 2 times 1.001 too.
  EXPECT_THAT(klipper,
              HasSubstr("[stepper_z]\nrotation_distance: 4.012008\n"
                        "[stepper_z1]\nrotation_distance: 4.008\n"
                        "[stepper_z2]\nrotation_distance: 4.008\n"));
  EXPECT_THAT(klipper, Not(HasSubstr("M92")));
  EXPECT_THROW(RequireScrewLevelling(ControllerKind::kLinuxCnc), InputError);
}

TEST(TripleZCorrection, WhereNoScrewMovedAloneNoPlaceIsWritten) {
  Diagnosis found = AnswerThatFinds({});
  found.absorbed.push_back({"pivot_position.z1", "all screws move alike"});
  const std::string text =
      TripleZCorrectionText(ControllerKind::kRrf, found, OneTouch());

  EXPECT_THAT(text, HasSubstr("no row moves a screw alone"));
  EXPECT_THAT(text, Not(HasSubstr("M671")));
}

}  // namespace
}  // namespace caltwin

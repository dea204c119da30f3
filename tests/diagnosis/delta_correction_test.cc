#include "calibration/diagnosis/kinds/delta_correction.h"

#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/input_error.h"
#include "sim/base/units.h"
#include "sim/firmware/kinds/delta/marlin.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/delta/model.h"
#include "tests/diagnosis/eighty_steps_delta.h"
#include "tests/firmware/delta_bed.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kRadius_mm = 100;
constexpr double kPretravel_mm = 0.02;  // Readings are that much lower than the bed.

Machine Drawn() {
  Machine machine = EightyStepsDelta();
  machine.probe.pretravel_mm = kPretravel_mm;
  return machine;
}

Observed SomeTouch() {
  Row row{.kind = RowKind::kTouch, .setup = "bed"};
  row.cmd_mm = {0, 0, 0};
  row.n = {0, 0, 1};
  row.feature = "bed.top";
  row.value_mm = 0;
  return {{.rows = {row}}, {}, Drawn(), {}};
}

// A machine that is off by what the lines say, told to a tenth of it.
Diagnosis OutOfCalibration() {
  Diagnosis diagnosis;
  const auto add = [&](const char* name, const char* unit, double value) {
    diagnosis.baseline.push_back({name, unit, value, std::abs(value) / 10});
  };
  add("endstop.a", "mm", 0.3);
  add("endstop.b", "mm", -0.2);
  add("delta_radius", "mm", 0.8);
  add("tower_angle.a", "deg", 0.35);
  add("tower_angle.b", "deg", -0.25);
  add("arm_length", "mm", 0.4);
  add("placement.bed.z", "mm", -0.15 + kPretravel_mm);
  return diagnosis;
}

// The same machine, by hand.
DeltaBuild<double> BuiltSo() {
  DeltaBuild<double> build = DeltaOf(Drawn()).Build();
  build.model.endstop_mm = {300.3, 299.8, 299.9};
  build.model.radius_mm.fill(130.8);
  build.model.angle_rad[0] += RadFromDeg(0.35);
  build.model.angle_rad[1] -= RadFromDeg(0.25);
  build.model.arm_mm.fill(250.4);
  return build;
}
const DeltaBed<double> kBed{.height_mm = -0.15};

DeltaModel<double> ByMarlin(const std::string& text) {
  const DeltaModel<double> drawn = DeltaOf(Drawn()).model;
  DeltaBedPlant bed(drawn, /*bed_mm=*/0);
  MarlinDelta marlin(drawn, drawn, {80, 80, 80}, &bed, {});
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    EXPECT_FALSE(marlin.Execute(line.substr(0, line.find(';'))).error) << line;
  }
  return marlin.settings();
}

double After(const std::string& text, const std::string& before) {
  const std::size_t at = text.find(before);
  EXPECT_NE(at, std::string::npos) << before << " in\n" << text;
  return at == std::string::npos ? NAN : std::stod(text.substr(at + before.size()));
}

DeltaModel<double> ByKlipper(const std::string& text) {
  DeltaModel<double> model;
  model.radius_mm.fill(After(text, "delta_radius: "));
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string own =
        text.substr(text.find("[stepper_" + TowerName(static_cast<int>(i)) + "]"));
    model.endstop_mm[i] = After(own, "position_endstop: ");
    model.arm_mm[i] = After(own, "arm_length: ");
    model.angle_rad[i] = RadFromDeg(After(own, "angle: "));
  }
  return model;
}

DeltaModel<double> ByRrf(const std::string& text) {
  DeltaModel<double> model = DeltaOf(Drawn()).model;
  const std::string geometry = text.substr(text.find("M665"));
  const std::string ends = geometry.substr(geometry.find("M666"));
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string letter = std::string(" ") + "XYZ"[i];
    model.endstop_mm[i] = After(geometry, " H") + After(ends, letter);
    model.angle_rad[i] += RadFromDeg(After(geometry, letter));
  }
  model.radius_mm.fill(After(geometry, " R"));
  // One rod length, or a:b:c.
  std::istringstream rods(geometry.substr(geometry.find(" L") + 2));
  rods >> model.arm_mm[0];
  model.arm_mm.fill(model.arm_mm[0]);
  for (std::size_t i = 1; i < 3 && rods.peek() == ':'; ++i) {
    rods.ignore();
    rods >> model.arm_mm[i];
  }
  return model;
}

std::string TextFor(ControllerKind controller, const Diagnosis& diagnosis) {
  return DeltaCorrectionText(controller, diagnosis, SomeTouch());
}

// Each controller's text, read as that controller reads it and held against the
// machine, which three rods describe: four decimals of each number are left.
TEST(DeltaCorrection, AppliedToTheMachineLeavesItsHeightsAndSizesRight) {
  constexpr double kRounding_mm = 3e-4;
  constexpr double kRounded_scale = 1e-5;
  const DeltaAccuracy before =
      DeltaAccuracyOf(BuiltSo(), kBed, DeltaOf(Drawn()).settings, kRadius_mm);
  ASSERT_GT(before.z_rms_mm, 0.1);
  ASSERT_GT(std::abs(before.xy_scale), 1e-3);
  const Diagnosis diagnosis = OutOfCalibration();

  for (const DeltaModel<double>& settings :
       {ByMarlin(TextFor(ControllerKind::kMarlin, diagnosis)),
        ByKlipper(TextFor(ControllerKind::kKlipper, diagnosis)),
        ByRrf(TextFor(ControllerKind::kRrf, diagnosis))}) {
    const DeltaAccuracy after = DeltaAccuracyOf(BuiltSo(), kBed, settings, kRadius_mm);
    EXPECT_LT(after.z_rms_mm, kRounding_mm);
    EXPECT_LT(std::abs(after.xy_scale), kRounded_scale);
  }
}

// No firmware has a number for the bed's slope: the machine is turned to follow it.
TEST(DeltaCorrection, FollowsATiltedBed) {
  const DeltaBed<double> tilted{.slope_x = 2e-3, .slope_y = -1e-3};
  const Diagnosis diagnosis{
      .baseline = {{"placement.bed.z", "mm", kPretravel_mm, 0.001},
                   {"bed_plane.slope_x", "mrad", 2, 0.01},
                   {"bed_plane.slope_y", "mrad", -1, 0.01}}};
  const auto off_mm = [&](const DeltaModel<double>& settings) {
    const DeltaBuild<double> build = DeltaOf(Drawn()).Build();
    return DeltaAccuracyOf(build, tilted, settings, kRadius_mm).z_rms_mm;
  };

  EXPECT_LT(off_mm(ByMarlin(TextFor(ControllerKind::kMarlin, diagnosis))),
            off_mm(DeltaOf(Drawn()).settings) / 20);
}

// A leaning tower is no number of any firmware; the best of three rods is still better.
TEST(DeltaCorrection, OfALeaningTowerDoesWhatThreeRodsCan) {
  Diagnosis diagnosis;
  diagnosis.baseline = {{"placement.bed.z", "mm", kPretravel_mm, 0.001}};
  diagnosis.findings.push_back(
      {.cause = "tower_lean",
       .axis = "b",
       .effect = Injected{
           .effect = *FindEffect("tower_lean"), .axis = "b", .values = {3, -2}}});
  DeltaBuild<double> build = DeltaOf(Drawn()).Build();
  build.lean_radial_rad[1] = 3e-3;
  build.lean_tangential_rad[1] = -2e-3;
  const auto off_mm = [&](const DeltaModel<double>& settings) {
    return DeltaAccuracyOf(build, {}, settings, kRadius_mm).z_rms_mm;
  };

  const std::string text = TextFor(ControllerKind::kMarlin, diagnosis);

  EXPECT_LT(off_mm(ByMarlin(text)), off_mm(DeltaOf(Drawn()).settings) / 20);
  EXPECT_THAT(text, HasSubstr("; tower_lean.b: three rods have no number for it"));
}

TEST(DeltaCorrection, OfAStretchedBeltIsThatTowersStepsPerMm) {
  Diagnosis diagnosis;
  diagnosis.findings.push_back(
      {.cause = "belt_pitch",
       .axis = "b",
       .effect = Injected{
           .effect = *FindEffect("belt_pitch"), .axis = "b", .values = {500}}});
  // 200 full steps of 16 on 40 mm a turn.
  const double drawn_steps_per_mm = 80;

  const std::string marlin = TextFor(ControllerKind::kMarlin, diagnosis);
  const std::string klipper = TextFor(ControllerKind::kKlipper, diagnosis);

  EXPECT_NEAR(After(marlin, "M92 Y"), drawn_steps_per_mm / 1.0005, 1e-5);
  EXPECT_NEAR(After(klipper, "[stepper_b]\nrotation_distance: "), 40 * 1.0005, 1e-5);
  EXPECT_THAT(marlin, Not(HasSubstr("M665")));
  EXPECT_THAT(klipper, Not(HasSubstr("[stepper_a]")));
}

// What two standard deviations do not tell is no correction.
TEST(DeltaCorrection, OfWhatIsNotToldSetsNothing) {
  Diagnosis diagnosis = OutOfCalibration();
  for (BaselineLine& line : diagnosis.baseline) line.sd = std::abs(line.value);

  const std::string text = TextFor(ControllerKind::kMarlin, diagnosis);

  EXPECT_THAT(text, HasSubstr("; geometry: not told"));
  EXPECT_THAT(text, Not(HasSubstr("\nM")));
}

TEST(DeltaCorrection, LeavesABentBedToItsMesh) {
  Diagnosis diagnosis;
  diagnosis.findings.push_back(
      {.cause = "bed_bowl",
       .effect = Injected{.effect = *FindEffect("bed_bowl"), .values = {150}}});

  const std::string text = TextFor(ControllerKind::kKlipper, diagnosis);

  EXPECT_THAT(text, HasSubstr("# bed_bowl: a mesh carries it: BED_MESH_CALIBRATE"));
  EXPECT_THAT(text, Not(HasSubstr("delta_radius:")));
}

TEST(DeltaCorrection, LinuxCncHasNoNumbersForIt) {
  EXPECT_THROW(TextFor(ControllerKind::kLinuxCnc, {}), InputError);
}

}  // namespace
}  // namespace caltwin

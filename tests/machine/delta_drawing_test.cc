#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/machine.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;

Machine ReadDelta(const std::string& text) {
  Faults faults;
  YamlMap map = ReadYamlText(text, "m.yaml", &faults);
  Machine machine = ReadMachine(&map);
  faults.ThrowIfAny();
  return machine;
}

std::string FaultOfDelta(const std::string& text) {
  try {
    ReadDelta(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(DeltaDrawing, OfKinematicsAloneIsTheUsualOne) {
  const Machine machine = ReadDelta("kinematics: delta\n");

  ASSERT_NE(machine.Own<DeltaDrawing>(), nullptr);
  EXPECT_EQ(DeltaOf(machine).model.arm_mm[0], 250);
  EXPECT_EQ(DeltaOf(machine).settings.radius_mm[2], 130);
  EXPECT_DOUBLE_EQ(machine.axes[0].steps_per_mm(), 80);
}

// Else every bed would be told to lie higher by what gives way.
TEST(DeltaDrawing, ANozzleDoesNotGiveWayUnlessAProbeIsStated) {
  const std::string delta = "kinematics: delta\n";

  EXPECT_LT(ReadDelta(delta).probe.pretravel_mm, 1e-5);
  EXPECT_EQ(ReadDelta(delta + "probe: {pretravel_mm: 0.3}\n").probe.pretravel_mm, 0.3);
}

TEST(DeltaDrawing, TakesANumberOrOneATower) {
  const Machine machine = ReadDelta(
      "kinematics: delta\n"
      "delta_radius_mm: 140\n"
      "endstop_mm: {a: 301, c: 302}\n"
      "arm_length_mm: {a: 288.1, b: 288.2, c: 288.3}\n"
      "towers: {a: {angle_deg: 211}}\n"
      "settings: {delta_radius_mm: 140.5, tower_angle_deg: {b: 0.25}}\n");
  const DeltaDrawing& delta = DeltaOf(machine);

  EXPECT_EQ(delta.model.radius_mm[1], 140);
  EXPECT_EQ(delta.model.endstop_mm[1], 300);
  EXPECT_EQ(delta.model.endstop_mm[2], 302);
  EXPECT_EQ(delta.model.arm_mm[2], 288.3);
  EXPECT_NEAR(delta.model.angle_rad[0] * 180 / M_PI, 211, 1e-12);
  EXPECT_EQ(delta.settings.radius_mm[0], 140.5);
  EXPECT_NEAR(delta.settings.angle_rad[1] * 180 / M_PI, 330.25, 1e-12);
}

TEST(DeltaDrawing, RefusesRodsThatDoNotReachAndUnknownKeys) {
  EXPECT_THAT(FaultOfDelta("kinematics: delta\narm_length_mm: 100\n"),
              HasSubstr("arm_length_mm = 100 is not above delta_radius_mm = 130"));
  EXPECT_THAT(FaultOfDelta("kinematics: delta\ndelta_radus_mm: 100\n"),
              HasSubstr("did you mean 'delta_radius_mm'"));
  EXPECT_THAT(FaultOfDelta("kinematics: delta\nendstop_mm: {d: 1}\n"),
              HasSubstr("has no key 'd'"));
  EXPECT_THAT(FaultOfDelta("kinematics: delta\naxes: {x: {max_mm: 3, lead_mm: 4}}\n"),
              HasSubstr("has no key 'x'"));
}

}  // namespace
}  // namespace caltwin

// RepRapFirmware's configuration of machines that are no deltas.

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/yaml.h"
#include "sim/machine/kinds/triple_z/drawing.h"
#include "sim/machine/machine.h"
#include "sim/machine/machine_kind.h"
#include "sim/measure/import/import.h"

namespace caltwin {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

Imported Read(const std::string& text) {
  return ImportText("rrf-config", text, "sys/config.g", {});
}

Machine MachineOf(const std::string& text) {
  Faults faults;
  const Imported imported = Read(text);
  YamlMap map = ReadYamlText(imported.machine_yaml, "m.yaml", &faults);
  Machine machine = ReadMachine(&map);
  faults.ThrowIfAny();
  return machine;
}

std::string FaultOf(const std::string& text) {
  try {
    Read(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

constexpr const char* kDrives = "M350 X16 Y16 Z16 E16 I1\nM92 X80 Y100 Z400:400 E420\n";

std::string WithDrives(const std::string& more) {
  return "M350 X16 Y16 Z16 E16 I1\nM92 X80 Y100 Z400 E420\n" + more;
}

TEST(RrfConfig, OfStraightAxesIsTheirDrivesAndTravels) {
  const Machine machine = MachineOf(
      WithDrives("M208 X-5 Y0 Z-0.5 S1 ; least\nM208 X300 Y310 Z250 S0\nM425 X0.05\n"));

  EXPECT_DOUBLE_EQ(machine.axes[0].min_mm, -5);
  EXPECT_DOUBLE_EQ(machine.axes[1].max_mm, 310);
  EXPECT_DOUBLE_EQ(machine.axes[2].min_mm, -0.5);
  EXPECT_DOUBLE_EQ(machine.axes[0].lead_mm, 40);
  EXPECT_DOUBLE_EQ(machine.axes[1].lead_mm, 32);
  EXPECT_DOUBLE_EQ(machine.settings.steps_per_mm[2], 400);
  EXPECT_DOUBLE_EQ(machine.settings.backlash_mm[0], 0.05);
}

TEST(RrfConfig, TakesBothEndsOfAnAxisFromOneWord) {
  const Machine machine = MachineOf(WithDrives("M208 X-5:300 Y0:310 Z-0.5:250\n"));

  EXPECT_DOUBLE_EQ(machine.axes[0].min_mm, -5);
  EXPECT_DOUBLE_EQ(machine.axes[0].max_mm, 300);
  EXPECT_DOUBLE_EQ(machine.axes[2].max_mm, 250);
}

TEST(RrfConfig, WithoutTravelsSaysThatTheyAreToBePut) {
  const Imported imported = Read(WithDrives(""));

  EXPECT_THAT(imported.machine_yaml, HasSubstr("Travels are not in it: put yours"));
}

TEST(RrfConfig, HasTheThreeScrewsOfM671) {
  const Machine machine = MachineOf(
      WithDrives("M208 X0:235 Y0:235 Z0:250\nM671 X20:215:20 Y20:20:215 S5\n"));

  EXPECT_EQ(machine.kind->name(), "triple_z");
  const TripleZDrawing& bed = TripleZOf(machine);
  EXPECT_DOUBLE_EQ(bed.screws[1].at_mm[0], 215);
  EXPECT_DOUBLE_EQ(bed.screws[2].at_mm[1], 215);
  EXPECT_DOUBLE_EQ(bed.screws[0].lead_mm, 8);
}

TEST(RrfConfig, TellsACoreXyByM669) {
  const std::string yaml = Read(WithDrives("M669 K1\n")).machine_yaml;

  EXPECT_THAT(yaml, HasSubstr("kinematics: corexy"));
  EXPECT_THAT(yaml, HasSubstr("steps_per_mm: {a: 80, b: 100, z: 400}"));
  EXPECT_THAT(Read(WithDrives("M667 S1\n")).machine_yaml,
              HasSubstr("kinematics: corexy"));
}

TEST(RrfConfig, TellsScrewsThatNoMachineFileHolds) {
  const Imported imported = Read(WithDrives("M671 X-20:320 Y150:150\n"));

  EXPECT_THAT(imported.warnings, ElementsAre(HasSubstr("M671 has 2 screws")));
  EXPECT_THAT(Read(WithDrives("")).warnings, IsEmpty());
}

TEST(RrfConfig, RefusesWhatCannotBe) {
  EXPECT_THAT(FaultOf("M208 X300 Y300 Z250\n"), HasSubstr("no machine among them"));
  EXPECT_THAT(FaultOf(kDrives), HasSubstr("M92 Z = '400:400' is not"));
  EXPECT_THAT(FaultOf(WithDrives("M671 X0:1:2 Y0:1\n")),
              HasSubstr("config.g:3:7: M671 has 3 X and 2 Y"));
  EXPECT_THAT(FaultOf("M92 X0 Y80 Z400\n"),
              HasSubstr("config.g:1:6: M92 X0: steps/mm are from 0.001"));
  EXPECT_THAT(FaultOf(WithDrives("M671 X0:0:0 Y0:0:0\nM208 X0:1 Y0:1 Z0:1\n")),
              HasSubstr("config.g as a machine"));
}

}  // namespace
}  // namespace caltwin

#include "sim/controllers/linuxcnc/own_ini.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/input_error.h"
#include "sim/kinds/cartesian/linuxcnc.h"
#include "sim/machine/kinds/cartesian/drawing.h"
#include "sim/machine/machine.h"

namespace caltwin {
namespace {

using linuxcnc::IniValue;
using testing::HasSubstr;
using testing::Not;

// Inches, a rotary axis, a Y that turns the other way, no switch at Z.
const std::string kMill =
    "[EMC]\nMACHINE = mill\n[DISPLAY]\nDISPLAY = axis\n[KINS]\nKINEMATICS = trivkins\n"
    "JOINTS = 4\n[TRAJ]\nCOORDINATES = X Y Z A\nLINEAR_UNITS = inch\n[EMCMOT]\n"
    "EMCMOT = motmod\nSHMEM_KEY = 111\nBASE_PERIOD = 50000\n[HAL]\nHALFILE = a.hal\n"
    "HALFILE = b.hal\n[AXIS_X]\nMIN_LIMIT = -0.1\nMAX_LIMIT = 12\nMAX_VELOCITY = 1.5\n"
    "[JOINT_0]\nINPUT_SCALE = 16000\nBACKLASH = 0.001\nHOME_OFFSET = -0.05\n"
    "HOME_SEARCH_VEL = -0.4\nHOME_LATCH_VEL = 0.02\n[AXIS_Y]\nMIN_LIMIT = 0\n"
    "MAX_LIMIT = 8\nMAX_VELOCITY = 1.5\n[JOINT_1]\nSCALE = -16000\nHOME_OFFSET = 8\n"
    "HOME_SEARCH_VEL = 0.4\n[AXIS_Z]\nMIN_LIMIT = -4\nMAX_LIMIT = 0\n"
    "MAX_VELOCITY = 1\n[JOINT_2]\nSCALE = 32000\nHOME_SEARCH_VEL = 0\n[AXIS_A]\n"
    "MIN_LIMIT = -9999\n[JOINT_3]\nSCALE = 100\n";

Machine MachineOf(const std::string& ini) {
  Faults faults;
  YamlMap map =
      ReadYamlText(linuxcnc::MachineFileOfIni(ini, "my.ini", "mill"), "m", &faults);
  const Machine machine = ReadMachine(&map);
  faults.ThrowIfAny();
  return machine;
}

std::string With(std::string ini, const std::string& old, const std::string& by) {
  return ini.replace(ini.find(old), old.size(), by);
}

TEST(MachineOfIni, IsInMillimetresAndItsTableAtZero) {
  const Machine mill = MachineOf(kMill);
  EXPECT_NEAR(mill.axes[0].min_mm, -0.05 * 25.4, 1e-6);  // Its switch.
  EXPECT_NEAR(mill.axes[0].max_mm, 12 * 25.4, 1e-6);
  EXPECT_EQ(mill.axes[1].home, HomeEnd::kMax);
  EXPECT_NEAR(mill.axes[2].min_mm, -5, 1e-6);
  EXPECT_NEAR(mill.axes[2].max_mm, 4 * 25.4 - 5, 1e-6);
  EXPECT_NEAR(mill.settings.steps_per_mm[2], 32000 / 25.4, 1e-4);
}

TEST(MachineOfIni, TwoJointsOfYAreABeam) {
  const std::string ini =
      With(With(kMill, "X Y Z A", "X Y Z Y"), "SCALE = 100", "SCALE = 16000");
  const Machine mill = MachineOf(ini);
  ASSERT_NE(mill.Own<BeamDrawing>(), nullptr);
  const auto own = linuxcnc::WithTwin(ini, LinuxCncOfGantry(mill));
  EXPECT_THAT(IniValue(own.ini, "KINS", "KINEMATICS"), HasSubstr("coordinates=XYZY"));
  // The fourth joint is the second motor of Y, number 3; the third is Z.
  EXPECT_THAT(own.hal, HasSubstr("joint.3.motor-pos-cmd => caltwin.position-cmd-3"));
  EXPECT_THAT(own.hal, HasSubstr("joint.2.motor-pos-cmd => caltwin.position-cmd-2"));
}

TEST(MachineOfIni, WhatItCannotBeIsRefused) {
  const auto message = [](const std::string& ini) -> std::string {
    try {
      linuxcnc::MachineFileOfIni(ini, "my.ini", "mill");
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(message("[KINS]\nKINEMATICS = 5axiskins\n"), HasSubstr("trivkins"));
  EXPECT_THAT(message(With(kMill, "X Y Z A", "X Z")), HasSubstr("'XZ'"));
  EXPECT_THAT(message(With(kMill, "MAX_LIMIT = 12", "")),
              HasSubstr("MAX_LIMIT is neither in [AXIS_X] nor in [JOINT_0]"));
  EXPECT_THAT(message(With(kMill, "INPUT_SCALE", "SCALES")), HasSubstr("no SCALE"));
}

TEST(OwnIni, KeepsWhatThePersonSetAndExchangesTheCard) {
  const auto own = linuxcnc::WithTwin(kMill, LinuxCncOfGantry(MachineOf(kMill)));
  EXPECT_EQ(IniValue(own.ini, "JOINT_0", "BACKLASH"), "0.001");
  EXPECT_EQ(IniValue(own.ini, "JOINT_0", "HOME_OFFSET"), "-0.05");
  EXPECT_EQ(IniValue(own.ini, "JOINT_0", "SCALE"), "16000");
  EXPECT_EQ(IniValue(own.ini, "JOINT_1", "SCALE"), "16000");
  EXPECT_EQ(IniValue(own.ini, "HAL", "HALFILE"), "machine.hal");
  EXPECT_THAT(own.ini, Not(HasSubstr("b.hal")));
  EXPECT_THAT(own.ini, Not(HasSubstr("SHMEM_KEY")));
  EXPECT_THAT(own.ini, Not(HasSubstr("AXIS_A")));
  EXPECT_EQ(IniValue(own.ini, "TRAJ", "COORDINATES"), "XYZ");
  EXPECT_EQ(IniValue(own.ini, "TRAJ", "LINEAR_UNITS"), "inch");
  EXPECT_EQ(IniValue(own.ini, "KINS", "JOINTS"), "3");
  EXPECT_EQ(IniValue(own.ini, "JOINT_2", "HOME_SEQUENCE"), "0");
  EXPECT_EQ(IniValue(own.ini, "JOINT_0", "HOME_SEQUENCE"), "1");
}

// Z goes from -4 to 0 inch: raised by 4 inch less 5 mm, homed at the top, where its
// switch now is.
TEST(OwnIni, ZCountsFromTheTableAndHomesOnASwitch) {
  const auto own = linuxcnc::WithTwin(kMill, LinuxCncOfGantry(MachineOf(kMill)));
  const double top = 4 - 5 / 25.4;
  EXPECT_NEAR(std::stod(IniValue(own.ini, "AXIS_Z", "MAX_LIMIT")), top, 1e-6);
  EXPECT_NEAR(std::stod(IniValue(own.ini, "AXIS_Z", "MIN_LIMIT")), -5 / 25.4, 1e-6);
  EXPECT_NEAR(std::stod(IniValue(own.ini, "JOINT_2", "HOME_OFFSET")), top, 1e-6);
  EXPECT_GT(std::stod(IniValue(own.ini, "JOINT_2", "HOME_SEARCH_VEL")), 0);
  EXPECT_THAT(own.changes, testing::Contains(HasSubstr("yours on none")));
}

// The nominal places of both are Z's own, raised with it; corrections stay.
TEST(OwnIni, TablesGoAlongAndCountAsTheirJoint) {
  const std::string ini =
      With(With(kMill, "SCALE = 32000", "SCALE = 32000\nCOMP_FILE = a/z.comp"),
           "INPUT_SCALE = 16000",
           "INPUT_SCALE = 16000\nCOMP_FILE = x.comp");
  const auto own = linuxcnc::WithTwin(ini, LinuxCncOfGantry(MachineOf(ini)));
  ASSERT_EQ(own.tables.size(), 2U);
  EXPECT_EQ(own.tables[0].Raised("0 0 0.1\n"), "0 0 0.1\n");
  EXPECT_EQ(own.tables[1].from, "a/z.comp");
  EXPECT_EQ(IniValue(own.ini, "JOINT_2", "COMP_FILE"), own.tables[1].name);
  EXPECT_EQ(own.tables[1].name, "JOINT_2_z.comp");
  linuxcnc::OwnTable table{.raised = 2};
  EXPECT_EQ(table.Raised("# words\n-1 -1.01 -1.02\n"), "# words\n1 0.99 0.98\n");
  table.has_trims = true;
  EXPECT_EQ(table.Raised("-1 0.01 0.02\n"), "1 0.01 0.02\n");
}

TEST(MachineOfIni, WhatItIncludesIsAskedFor) {
  EXPECT_THROW(MachineOf("#INCLUDE joints.inc\n" + kMill), InputError);
}

// Found by its fuzzer: a beam's second motor that the machine file has not.
TEST(OwnIni, MachineOfAnotherFileIsRefused) {
  linuxcnc::MachineText drawn = LinuxCncOfGantry(MachineOf(kMill));
  drawn.joints.resize(1);
  EXPECT_THROW(linuxcnc::WithTwin(kMill, drawn), InputError);
}

}  // namespace
}  // namespace caltwin

#include "sim/measure/import/printer_cfg_adapted.h"

#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/text_file.h"
#include "sim/machine/kinds/corexy/drawing.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/triple_z/drawing.h"
#include "sim/machine/machine.h"
#include "sim/measure/import/kinds/printer_of_cfg.h"

namespace caltwin {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

constexpr std::size_t kLargest_bytes = 1 << 20;

std::string Sample(const char* name) {
  return ReadTextFile(std::filesystem::path("tests/fuzz/corpus/printer_cfg") / name,
                      kLargest_bytes);
}

Machine MachineOf(const std::string& config) {
  Faults faults;
  YamlMap map =
      ReadYamlText(MachineFileOf(PrinterCfg(config, "p.cfg"), "mine"), "m", &faults);
  const Machine machine = ReadMachine(&map);
  faults.ThrowIfAny();
  return machine;
}

// What SAVE_CONFIG has written counts.
TEST(PrinterOfCfg, ADeltaIsAsItsConfigurationHasIt) {
  const DeltaDrawing delta = DeltaOf(MachineOf(Sample("delta.cfg")));
  EXPECT_DOUBLE_EQ(delta.settings.radius_mm[0], 105.5);
  EXPECT_DOUBLE_EQ(delta.settings.arm_mm[2], 217);
  EXPECT_DOUBLE_EQ(delta.settings.endstop_mm[0], 297.2);
}

TEST(PrinterOfCfg, ThreeMotorsOfZAreScrews) {
  const Machine machine = MachineOf(Sample("screws.cfg"));
  EXPECT_EQ(machine.axes[0].home, HomeEnd::kMax);
  EXPECT_DOUBLE_EQ(machine.axes[0].max_mm, 250);
  // 40 mm a turn of the pulley, of which the motor makes ten.
  EXPECT_DOUBLE_EQ(machine.settings.steps_per_mm[0], 200 * 32 * 10 / 40.0);
  const TripleZDrawing& screws = TripleZOf(machine);
  EXPECT_DOUBLE_EQ(screws.screws[1].at_mm[1], 298);
  EXPECT_DOUBLE_EQ(screws.screws[2].lead_mm, 4);
}

TEST(PrinterOfCfg, AnotherKinematicsIsRefusedWhereItStands) {
  try {
    MachineOf("[printer]\nkinematics: polar\n");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("p.cfg:2:13"));
    EXPECT_THAT(error.what(), HasSubstr("delta, cartesian or corexy"));
  }
}

TEST(PrinterOfCfg, AnAxisWithoutItsTravelIsRefused) {
  std::string config = Sample("screws.cfg");
  config.replace(config.find("position_max: 250"), 17, "");
  EXPECT_THROW(MachineOf(config), InputError);
}

constexpr const char* kDrawn =
    "[mcu]\nserial: /tmp/twin\n[printer]\nminimum_z_position: "
    "-8\n[stepper_x]\nstep_pin: "
    "X_STEP\ndir_pin: X_DIR\nendstop_pin: X_STOP\n[stepper_z]\nstep_pin: Z_STEP\n"
    "endstop_pin: Z_STOP\nposition_min: -5\nposition_max: 240\nposition_endstop: 240\n"
    "[stepper_a]\nstep_pin: A_STEP\ndir_pin: A_DIR\nendstop_pin: A_STOP\n"
    "[probe]\nz_offset: -0.02\n[z_tilt]\nz_positions:\n";

TEST(AdaptedToTwin, MotorsEndstopsAndProbeGetItsPins) {
  const AdaptedConfig adapted = AdaptedToTwin(Sample("delta.cfg"), kDrawn);
  const PrinterCfg cfg(adapted.text, "p");
  EXPECT_EQ(cfg.Find("stepper_a", "dir_pin")->value.text, "A_DIR");
  EXPECT_EQ(cfg.Find("stepper_a", "endstop_pin")->value.text, "A_STOP");
  EXPECT_EQ(cfg.Find("stepper_a", "enable_pin"), nullptr);
  EXPECT_EQ(cfg.Find("stepper_a", "position_endstop")->value.text, "297.2");
  EXPECT_EQ(cfg.Find("mcu", "serial")->value.text, "/tmp/twin");
  EXPECT_EQ(cfg.Find("probe", "z_offset")->value.text, "-0.02");
  EXPECT_EQ(cfg.Find("printer", "minimum_z_position")->value.text, "-8");
  EXPECT_THAT(adapted.text, Not(HasSubstr("bltouch")));
}

TEST(AdaptedToTwin, WhatHasNoPartIsLeftOutAndNotHeard) {
  const AdaptedConfig adapted =
      AdaptedToTwin(Sample("screws.cfg") + "[extruder]\nheater_pin: PA2\n", kDrawn);
  EXPECT_THAT(adapted.changes, Contains(HasSubstr("[tmc2209 stepper_x]")));
  EXPECT_THAT(adapted.text, HasSubstr("[gcode_macro SET_TMC_CURRENT]\ngcode: G4 P0\n"));
  // A heater that macros may ask, and that nobody waits for.
  EXPECT_THAT(adapted.text, Not(HasSubstr("PA2")));
  EXPECT_THAT(adapted.text, HasSubstr("heater_pin: SPARE0\n"));
  EXPECT_THAT(
      adapted.text,
      HasSubstr("[gcode_macro M104]\nrename_existing: M1040000\ngcode: G4 P0\n"));
  // The person's own M109 stays, its indented lines too; what it renamed does nothing.
  EXPECT_THAT(adapted.text, HasSubstr("    M99109 S{s}\n"));
  EXPECT_THAT(adapted.text, HasSubstr("rename_existing: M991090000\n"));
  EXPECT_THAT(adapted.text, HasSubstr("[gcode_macro M99109]\ngcode: G4 P0\n"));
}

// The nozzle comes from 0 to 250 mm.
TEST(AdaptedToTwin, AMeshStaysWhereTheNozzleComes) {
  const AdaptedConfig adapted = AdaptedToTwin(Sample("screws.cfg"), kDrawn);
  EXPECT_THAT(adapted.text, HasSubstr("mesh_min: 0, 6\nmesh_max: 250, 235\n"));
}

TEST(AdaptedToTwin, ASwitchOfZAtTheOtherEndBecomesTheProbe) {
  const AdaptedConfig adapted = AdaptedToTwin(
      "[stepper_z]\nstep_pin: PA1\nendstop_pin: ^PA2\nposition_endstop: "
      "0\nposition_max: "
      "240\n[probe]\npin: PA3\nspeed: 4\nx_offset: 25\n",
      kDrawn);
  EXPECT_THAT(adapted.changes, Contains(HasSubstr("homes by the probe")));
  const PrinterCfg cfg(adapted.text, "p");
  EXPECT_EQ(cfg.Find("stepper_z", "endstop_pin")->value.text,
            "probe:z_virtual_endstop");
  EXPECT_EQ(cfg.Find("stepper_z", "position_endstop"), nullptr);
  EXPECT_EQ(cfg.Find("probe", "x_offset"), nullptr);
  EXPECT_EQ(cfg.Find("probe", "speed")->value.text, "4");
}

TEST(AdaptedToTwin, WithoutThoseMotorsNothingIsLevelledByThem) {
  const AdaptedConfig adapted = AdaptedToTwin(
      "[quad_gantry_level]\ngantry_corners:\n  0, 0\n  1, 1\n[printer]\n", kDrawn);
  EXPECT_THAT(adapted.text, Not(HasSubstr("gantry_corners")));
  EXPECT_THAT(adapted.changes, Contains(HasSubstr("[quad_gantry_level]")));
  EXPECT_THAT(adapted.text, HasSubstr("[gcode_macro QUAD_GANTRY_LEVEL]\n"));
}

// A page's [display_status] knows M117; a display that is left out would have loaded
// it.
TEST(AdaptedToTwin, ADisplayLeavesItsCommands) {
  for (const char* const more : {"", "[display_status]\n"}) {
    const AdaptedConfig adapted = AdaptedToTwin(
        "[printer]\n[display]\nlcd_type: st7920\n" + std::string(more), kDrawn);
    EXPECT_THAT(adapted.text, HasSubstr("[display_status]\n")) << more;
    EXPECT_THAT(adapted.text, Not(HasSubstr("M117"))) << more;
  }
}

TEST(AdaptedToTwin, SectionsInPartsAndCapitalKeysCount) {
  const AdaptedConfig adapted = AdaptedToTwin(
      "[probe]\nPin: PA1\nX_Offset = 3\n[printer]\n[probe]\nsamples: 5\n[stepper_x]\n"
      "Step_Pin: PA2\nmicrosteps: 8\n",
      kDrawn);
  const PrinterCfg cfg(adapted.text, "p");
  EXPECT_EQ(cfg.Find("probe", "pin")->value.text, "PROBE");
  EXPECT_EQ(cfg.Find("probe", "samples")->value.text, "5");
  EXPECT_EQ(cfg.Find("probe", "x_offset"), nullptr);
  EXPECT_EQ(cfg.Find("stepper_x", "step_pin")->value.text, "X_STEP");
}

TEST(PrinterCfg, FlagsAreReadAsKlipperReadsThem) {
  const PrinterCfg cfg("[a]\nB: On\nc = no\nd: 2\n", "p");
  EXPECT_EQ(cfg.Flag("a", "b"), std::optional(true));
  EXPECT_EQ(cfg.Flag("a", "c"), std::optional(false));
  EXPECT_EQ(cfg.Flag("a", "d"), std::nullopt);
  EXPECT_EQ(cfg.Flag("a", "e"), std::nullopt);
}

}  // namespace
}  // namespace caltwin

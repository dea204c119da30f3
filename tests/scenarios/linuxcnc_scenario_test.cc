#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenarios/runner.h"
#include "scenarios/scenario.h"
#include "sim/base/input_error.h"
#include "sim/base/text_file.h"
#include "tests/base/temp_folder.h"

namespace caltwin {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::string kMachine = "machine: gantry_router\nfidelity: fast\n";

std::string MessageOf(const std::string& text) {
  try {
    ReadScenarioText(text, "test.yaml");
    return "";
  } catch (const InputError& error) {
    return error.what();
  }
}

TEST(LinuxCncScenario, KnowsLinesSettingsFilesAndAProgram) {
  const TempFolder folder;
  WriteTextFile(folder.path() / "x.comp", "0 0 0\n");
  WriteTextFile(folder.path() / "job.ngc", "M2\n");
  const Scenario scenario = ReadScenarioText(
      kMachine +
          "controller: {linuxcnc: {mdi: [G0 X10], program: job.ngc, home: false, "
          "set: {JOINT_0.BACKLASH: 0.05}, files: [x.comp]}}\n",
      folder.path() / "test.yaml");
  ASSERT_TRUE(scenario.linuxcnc.has_value());
  EXPECT_FALSE(scenario.linuxcnc->is_homed_first);
  EXPECT_EQ(scenario.linuxcnc->program, "M2\n");
  EXPECT_THAT(scenario.linuxcnc->options.set, ElementsAre("JOINT_0.BACKLASH=0.05"));
  EXPECT_EQ(scenario.linuxcnc->program_name, "job.ngc");
  ASSERT_EQ(scenario.linuxcnc->more_files.size(), 1U);
  EXPECT_EQ(scenario.linuxcnc->more_files[0].first, "x.comp");
}

TEST(LinuxCncScenario, AProbeMayBeLatchedOrBounce) {
  const auto probe_of = [](const std::string& keys) {
    return ReadScenarioText(
               kMachine + "controller: {linuxcnc: {mdi: [G0]" + keys + "}}\n", "t.yaml")
        .linuxcnc->options.probe;
  };
  EXPECT_FALSE(probe_of("").is_latched);
  EXPECT_EQ(probe_of("").bounce_s, 0);
  EXPECT_TRUE(probe_of(", probe: {latch: true}").is_latched);
  EXPECT_DOUBLE_EQ(probe_of(", probe: {bounce_ms: 4}").bounce_s, 0.004);
  EXPECT_THAT(MessageOf(kMachine + "controller: {linuxcnc: {mdi: [G0], probe: {bounce: "
                                   "4}}}\n"),
              HasSubstr("has no key 'bounce'"));
}

TEST(LinuxCncScenario, OneControllerDrivesAMachine) {
  EXPECT_THAT(MessageOf(kMachine + "controller: {}\n"),
              HasSubstr("test.yaml:3:13: controller names one real controller"));
  EXPECT_THAT(MessageOf(kMachine + "controller: {linuxcnc: {mdi: [G0]}, klipper: "
                                   "{gcode: [G28]}}\n"),
              HasSubstr("klipper or linuxcnc"));
}

TEST(LinuxCncScenario, AMachineThatItCannotDriveIsRefused) {
  EXPECT_THAT(MessageOf("machine: corexy_printer\nfidelity: fast\n"
                        "controller: {linuxcnc: {mdi: [G0]}}\n"),
              HasSubstr("cannot yet be driven by LinuxCNC"));
  EXPECT_THAT(MessageOf("machine: triple_z_printer\nfidelity: fast\n"
                        "controller: {linuxcnc: {mdi: [G0]}}\n"),
              HasSubstr("cannot yet be driven by LinuxCNC"));
}

TEST(LinuxCncScenario, WhatCannotBeMeantIsRefusedWithItsPlace) {
  const auto message = [](const std::string& keys) {
    return MessageOf(kMachine + "controller: {linuxcnc: {" + keys + "}}\n");
  };
  EXPECT_THAT(message("mdi: []"), HasSubstr("test.yaml:3:30"));
  EXPECT_THAT(message("program: no.ngc"),
              HasSubstr("names a file that is not there: no.ngc"));
  EXPECT_THAT(message("ini: no.ini"),
              HasSubstr("names a file that is not there: no.ini"));
  EXPECT_THAT(message("files: [no.comp]"),
              HasSubstr("names a file that is not there: no.comp"));
  EXPECT_THAT(message("set: {BACKLASH: 1}"), HasSubstr("no section and key"));
  EXPECT_THAT(message("gcode: [G0]"), HasSubstr("gcode"));
  EXPECT_THAT(message("home: false"), HasSubstr("mdi"));
}

}  // namespace
}  // namespace caltwin

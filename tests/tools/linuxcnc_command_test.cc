#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/text_file.h"
#include "tests/base/temp_folder.h"
#include "tests/tools/caltwin_process.h"

namespace caltwin {
namespace {

using testing::Eq;
using testing::HasSubstr;

void ExpectRefused(const std::string& words, const std::string& why) {
  const Finished run = Caltwin(words);
  EXPECT_THAT(run.code, Eq(2)) << words;
  EXPECT_THAT(run.err, HasSubstr(why)) << words;
}

TEST(LinuxCncCommand, NewWritesAConfigurationAndNoSecondOverIt) {
  const TempFolder folder;
  const std::string words =
      "new linuxcnc gantry_router --page mill --out " + folder.path().string();
  EXPECT_THAT(Caltwin(words).code, Eq(0));
  const auto text = [&](const char* name) {
    return ReadTextFile(folder.path() / name, kLargestFile_bytes);
  };
  EXPECT_THAT(text("machine.ini"), HasSubstr("[JOINT_2]"));
  EXPECT_THAT(text("machine.ini"), HasSubstr("SCALE = 800\n"));
  EXPECT_THAT(text("machine.hal"), HasSubstr("loadrt caltwin page=mill\n"));
  EXPECT_THAT(text("caltwin.comp"), HasSubstr("component caltwin"));
  EXPECT_THAT(text("page.h"), HasSubstr("kCaltwinPageVersion"));
  ExpectRefused(words, "this file is already there");
}

TEST(LinuxCncCommand, AMachineThatItCannotDriveIsNamed) {
  ExpectRefused("new linuxcnc motor_stage --out /dev/null/x",
                "of kind motor_stage cannot yet be driven by LinuxCNC");
  ExpectRefused("linuxcnc corexy_printer -c G0", "not yet belts that two share");
}

TEST(LinuxCncCommand, NobodyElseSharesTheMachine) {
  ExpectRefused("serve --machine gantry_router --linuxcnc mill --tcp 0",
                "LinuxCNC alone drives the machine");
  ExpectRefused("serve --machine gantry_router --linuxcnc mill --klipper /tmp/nowhere",
                "take one of --klipper and --linuxcnc");
}

TEST(LinuxCncCommand, APageHasANameAndNoPath) {
  ExpectRefused(
      "serve --machine gantry_router --fidelity fast --linuxcnc ../etc/passwd",
      "'../etc/passwd' is no name for a page");
}

TEST(LinuxCncCommand, WhatIsSetHasASectionAKeyAndAValue) {
  ExpectRefused("linuxcnc gantry_router --set BACKLASH=1.5",
                "a section, a key and a value are wanted");
}

TEST(LinuxCncCommand, AMissingProgramIsRefusedBeforeAnythingMoves) {
  ExpectRefused("linuxcnc gantry_router --program no_such.ngc", "no_such.ngc");
}

}  // namespace
}  // namespace caltwin

#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/text_file.h"
#include "sim/measure/data_header.h"
#include "sim/measure/rows.h"
#include "tests/base/temp_folder.h"
#include "tests/tools/run_command.h"
#include "tools/commands/command.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

namespace fs = std::filesystem;

/// `caltwin import WORDS...`
Answer RunImport(const std::vector<std::string>& words) {
  return RunCommand(DeclareImport, words);
}

class ImportCommand : public ::testing::Test {
 protected:
  std::string Written(const std::string& name, const std::string& text) const {
    WriteTextFile(folder_ / name, text);
    return (folder_ / name).string();
  }
  std::string Out() const { return (folder_ / "rows.csv").string(); }

  static std::string Data(const std::string& name) {
    return std::string(CALTWIN_SOURCE_DIR) + "/tests/data/imports/" + name;
  }

  TempFolder folder_{};
};

TEST_F(ImportCommand, WritesRowsAndHeaderAndSaysWhatItTookThemFor) {
  const Answer answer = RunImport(
      {"klipper-thermal", Data("frame_log_2021-06-13_05-41.csv"), "--out", Out()});

  EXPECT_EQ(answer.exit_code, kPassed);
  EXPECT_THAT(answer.out, HasSubstr(Out() + ": 1203 rows from "));
  EXPECT_THAT(answer.out, HasSubstr("recognised a motor step is 0.0025 mm (line 3)\n"));
  EXPECT_THAT(answer.out, HasSubstr("assumed    mcu_pos_z counts upwards"));
  EXPECT_THAT(answer.out, HasSubstr("next:      caltwin diagnose " + Out() + "\n"));
  EXPECT_EQ(ReadRows(Out()).rows.size(), 1203u);
  EXPECT_EQ(HeaderOf(Out()).instruments.at("probe").resolution_um, 2.5);
}

TEST_F(ImportCommand, ARefusedFileLeavesNothingBehind) {
  const Answer answer = RunImport(
      {"klipper-thermal", Data("frame_log_2021-06-13_20-04.csv"), "--out", Out()});

  EXPECT_EQ(answer.exit_code, kBadInput);
  EXPECT_THAT(answer.fault, HasSubstr("frame_log_2021-06-13_20-04.csv:3:1: a step of"));
  EXPECT_THAT(answer.out, IsEmpty());
  EXPECT_FALSE(fs::exists(Out()));
  EXPECT_FALSE(fs::exists(folder_ / "rows.yaml"));
}

TEST_F(ImportCommand, WhatCannotBeTrueIsRefusedHoweverWellItReads) {
  const std::string sheet = Written(
      "sheet.csv", "pos,dev\n0,1\n10,31\n20,-25\n30,40\n40,-33\n50,20\n60,-41\n70,5\n");
  const auto with_unit = [&](const std::string& unit) {
    return RunImport({"csv",
                      sheet,
                      "--map",
                      "cmd_x_mm=pos[mm],value_mm=dev[" + unit + "]",
                      "--out",
                      Out()});
  };

  EXPECT_THAT(with_unit("mm").fault, HasSubstr("value_mm is in mm"));
  const Answer answer = with_unit("um");
  EXPECT_EQ(answer.exit_code, kPassed);
  EXPECT_THAT(answer.out, HasSubstr("note       no row along x says from which side"));
}

TEST_F(ImportCommand, TheFileReadIsNeverWrittenOver) {
  const std::string sheet = Written("s.csv", "1,2\n3,4\n5,7\n7,1\n9,3\n11,4\n");
  const Answer answer =
      RunImport({"csv", sheet, "--map", "cmd_x_mm=1,value_mm=2[um]", "--out", sheet});

  EXPECT_EQ(answer.exit_code, kBadInput);
  EXPECT_THAT(answer.fault,
              HasSubstr("is the file, which is read: it would be written over"));
}

TEST_F(ImportCommand, AMachineIsNotInventedWhereTheFileKnowsNone) {
  const Answer answer = RunImport({"cmm-plate",
                                   Data("plate_1396A_excerpt.txt"),
                                   "--out",
                                   Out(),
                                   "--machine-out",
                                   (folder_ / "m.yaml").string()});

  EXPECT_EQ(answer.exit_code, kBadInput);
  EXPECT_THAT(answer.fault, HasSubstr("cmm-plate says nothing of the machine"));
  EXPECT_FALSE(fs::exists(Out()));
}

TEST_F(ImportCommand, SaysThatASavedDeltaIsStaleAndWritesItsMachine) {
  const std::string machine = (folder_ / "m.yaml").string();

  const Answer answer = RunImport({"klipper-delta",
                                   Data("delta_v400_fixes.cfg"),
                                   "--out",
                                   Out(),
                                   "--machine-out",
                                   machine});

  EXPECT_EQ(answer.exit_code, kPassed);
  EXPECT_THAT(answer.out, HasSubstr("finds      STALE: the saved geometry does not"));
  EXPECT_THAT(answer.out,
              HasSubstr("heights: 129.8 um rms as saved, 16.7 um by a fit"));
  EXPECT_THAT(answer.out, HasSubstr("diagnose " + Out() + " --machine " + machine));
  EXPECT_EQ(ReadRows(Out()).rows.size(), 7u);
  EXPECT_THAT(ReadTextFile(machine, 10'000), HasSubstr("kinematics: delta"));
}

// The step that the touches suggest and the verdict on the geometry hang on the same
// endstops: what each rests on is told.
TEST_F(ImportCommand, AStepGivenByHandMayBeWhatDoesNotBelong) {
  const auto with_step = [](const std::string& step) {
    return RunImport({"klipper-delta", Data("delta_no_step.cfg"), "--step-mm", step})
        .out;
  };

  EXPECT_THAT(with_step("0.0125"),
              HasSubstr("its endstops are those of these touches: delta radius or "
                        "angles were changed after them"));
  EXPECT_THAT(with_step("0.01"),
              HasSubstr("or --step-mm 0.01 is not this machine's motor step: the touch "
                        "nearest to the middle suggests 0.0125"));
}

TEST_F(ImportCommand, WritesNothingThatWasNotAskedFor) {
  const fs::path was = fs::current_path();
  fs::current_path(folder_.path());
  const Answer answer = RunImport({"klipper-delta", Data("delta_super_racer.cfg")});
  fs::current_path(was);

  EXPECT_EQ(answer.exit_code, kPassed);
  EXPECT_THAT(answer.out, HasSubstr("finds      the saved geometry belongs"));
  EXPECT_THAT(answer.out,
              HasSubstr("next:      nothing was written; the same with --out DATA.csv "
                        "--machine-out M.yaml writes the rows\n"));
  EXPECT_TRUE(fs::is_empty(folder_.path()));
}

// Counts stand beside the rows for people; nobody misspelt them.
TEST_F(ImportCommand, ItsOwnColumnsAreNoRemarks) {
  RunImport({"klipper-delta", Data("delta_super_racer.cfg"), "--out", Out()});

  EXPECT_THAT(ReadRows(Out()).remarks, IsEmpty());
}

TEST_F(ImportCommand, JudgesTheMeshOfADelta) {
  const Answer answer =
      RunImport({"klipper-mesh", Data("mesh_v400.cfg"), "--out", Out()});

  EXPECT_EQ(answer.exit_code, kPassed);
  EXPECT_THAT(answer.out, HasSubstr("finds      mesh 'default': neither: nothing"));
}

TEST_F(ImportCommand, ShowsAMachineThatHasNoRows) {
  const std::string file = Written("config.g", "M665 L440 R235 H410\n");

  EXPECT_THAT(RunImport({"rrf-config", file}).out, HasSubstr("delta_radius_mm: 235.0"));
  EXPECT_THAT(RunImport({"rrf-config", file, "--out", Out()}).fault,
              HasSubstr("measures nothing: there are no rows"));
}

}  // namespace
}  // namespace caltwin

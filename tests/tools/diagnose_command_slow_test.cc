// `caltwin diagnose` of rows whose machine nobody described.
#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenarios/machine_file.h"
#include "sim/base/text_file.h"
#include "tests/base/temp_folder.h"
#include "tests/tools/run_command.h"
#include "tools/commands/command.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

TEST(DiagnoseCommand, ExtendsTheMachineThatItAssumed) {
  const TempFolder folder;
  const std::string rows = "tests/data/iso230/ess_target_y_2022-04.csv";
  const std::string extension = (folder / "axis.ext.yaml").string();

  EXPECT_THAT(Printed(DeclareDiagnose, {rows, "--extend", extension}),
              HasSubstr("axis.machine.yaml, the machine as it was assumed. Put your "
                        "own sizes there"));
  EXPECT_EQ(
      ReadAnyMachineFile(folder / "axis.machine.yaml").machine.axis(Axis::kY).min_mm,
      -20);
  EXPECT_THAT(Printed(DeclareDiagnose, {rows, "--machine", extension}),
              StartsWith("Verdict: none."));
}

TEST(DiagnoseCommand, PutsNoOtherOutputOverTheAssumedMachine) {
  const Answer answer = RunCommand(DeclareDiagnose,
                                   {"tests/data/iso230/ess_target_y_2022-04.csv",
                                    "--extend",
                                    "x.ext.yaml",
                                    "--json",
                                    "x.machine.yaml"});

  EXPECT_EQ(answer.exit_code, kBadInput);
  EXPECT_THAT(answer.fault, HasSubstr("x.machine.yaml"));
}

TEST(DiagnoseCommand, PutsTheAssumedMachineOverNoOther) {
  const TempFolder folder;
  const std::string mine = "# My own sizes.\n";
  std::ofstream(folder / "axis.machine.yaml") << mine;

  const Answer answer = RunCommand(DeclareDiagnose,
                                   {"tests/data/iso230/ess_target_y_2022-04.csv",
                                    "--extend",
                                    (folder / "axis.ext.yaml").string()});

  EXPECT_EQ(answer.exit_code, kBadInput);
  EXPECT_THAT(answer.fault, HasSubstr("axis.machine.yaml"));
  EXPECT_EQ(ReadTextFile(folder / "axis.machine.yaml", mine.size() + 1), mine);
  EXPECT_FALSE(std::filesystem::exists(folder / "axis.ext.yaml"));
}

}  // namespace
}  // namespace caltwin

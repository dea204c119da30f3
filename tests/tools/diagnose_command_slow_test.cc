// `caltwin diagnose` of rows whose machine nobody described.
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <string>
#include <utility>

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

// Rows as a plan makes them that states no noise: they end on whole steps, and four
// temperatures are as many as a table has terms.
TEST(DiagnoseCommand, OfAStationsExactRowsNamesWhatGrows) {
  const TempFolder folder;
  const auto file = [&](const char* name) {
    return (folder / name).string();
  };
  std::ofstream(file("plan.yaml"))
      << "machine: z_station\nseed: 9\ncampaigns: [z_offset, z_gap]\n";
  for (const auto& [effect, says] :
       std::initializer_list<std::pair<const char*, const char*>>{
           {"nozzle_temperature: {growth_um_per_k: 0.2}", "The nozzle grows by 0.20 "},
           {"nozzle_temperature: {growth_um_per_k: 0.3}", "The nozzle grows by 0.30 "},
           {"nozzle_temperature: {growth_um_per_k: 1}", "The nozzle grows by 1.00 "},
           {"nozzle_temperature: {growth_um_per_k: 2}", "The nozzle grows by 2.0"},
           {"frame_temperature.bed: {growth_um_per_k: 1, lag_s: 600}",
            "The bed grows along Z by 1.0"}}) {
    std::ofstream(file("truth.yaml")) << "effects: {" << effect << "}\n";
    Printed(DeclareSimulate,
            {file("plan.yaml"), "--truth", file("truth.yaml"), "--out", file("d.csv")});

    const std::string said = Printed(DeclareDiagnose, {file("d.csv")});

    EXPECT_THAT(said, StartsWith("Verdict: named.")) << effect;
    EXPECT_THAT(said, HasSubstr(says));
  }
}

// Three rows of the nozzle alone and lost steps show alike: none is named.
TEST(DiagnoseCommand, OfANozzleChangedAtTheEndNamesNoLostSteps) {
  const TempFolder folder;
  const auto file = [&](const char* name) {
    return (folder / name).string();
  };
  std::ofstream(file("plan.yaml")) << "machine: z_station\nseed: 3\ninstruments: "
                                      "{probe: {sigma_um: 2}}\n"
                                      "campaigns: [z_offset, z_gap]\n";
  std::ofstream(file("truth.yaml"))
      << "effects: {station_change.nozzle: {step_um: -60, at_t_s: 15000}}\n";
  Printed(DeclareSimulate,
          {file("plan.yaml"), "--truth", file("truth.yaml"), "--out", file("d.csv")});

  const std::string said = Printed(DeclareDiagnose, {file("d.csv")});

  EXPECT_THAT(said, StartsWith("Verdict: ambiguous."));
  EXPECT_THAT(said, HasSubstr("The nozzle was changed at"));
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

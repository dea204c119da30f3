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

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr std::size_t kMostBytes = 1 << 20;

class SimulateCommand : public ::testing::Test {
 protected:
  SimulateCommand() {
    Write("plan.yaml",
          "machine: gantry_router\nseed: 4\n"
          "instruments: {laser: {sigma_um: 0.5}}\n"
          "campaigns:\n  - iso230: {axis: x, positions: 3, runs: 1}\n"
          "  - plate: {grid: [2, 2], repeats: 1}\n");
  }

  std::string File(const std::string& name) const { return (folder_ / name).string(); }
  void Write(const std::string& name, const std::string& text) const {
    WriteTextFile(folder_ / name, text);
  }
  std::string Read(const std::string& name) const {
    return ReadTextFile(folder_ / name, kMostBytes);
  }

  /// `caltwin simulate WORDS...`: what it prints.
  static std::string Simulate(const std::vector<std::string>& words) {
    return Printed(DeclareSimulate, words);
  }
  static std::string FaultOf(const std::vector<std::string>& words) {
    return RunCommand(DeclareSimulate, words).fault;
  }

 private:
  TempFolder folder_{};
};

TEST_F(SimulateCommand, WritesRowsAndTheHeaderThatExplainsThem) {
  EXPECT_THAT(Simulate({File("plan.yaml"), "--out", File("data.csv")}),
              HasSubstr("10 readings of 2 campaigns"));

  const RowTable table = ReadRows(File("data.csv"));
  EXPECT_EQ(table.rows.size(), 10U);
  const DataHeader header = HeaderOf(File("data.csv"));
  EXPECT_EQ(header.machine, "gantry_router");
  EXPECT_EQ(header.campaigns.at("iso230").options.at("positions"), "3");
  EXPECT_EQ(header.settings.at("1").steps_per_mm.at("x"), 800);
  EXPECT_THAT(Unexplained(table, header), ::testing::IsEmpty());
}

TEST_F(SimulateCommand, HidesTheTruthInTheRowsAlone) {
  Write("truth.yaml",
        "effects: {backlash.x: {gap_mm: 0.06}}\nsettings: {steps_per_mm: {x: 801}}\n");

  Simulate(
      {File("plan.yaml"), "--truth", File("truth.yaml"), "--out", File("data.csv")});

  const auto rows = ReadRows(File("data.csv")).rows;
  // At the same target, coming from either side.
  EXPECT_NEAR(rows[3].value_mm - rows[2].value_mm, 0.06, 0.004);
  EXPECT_NEAR(rows[2].value_mm, rows[2].cmd_mm[0] / 800 - 0.03, 0.004);
  EXPECT_THAT(Read("data.yaml"), ::testing::Not(HasSubstr("backlash.x")));
  EXPECT_EQ(HeaderOf(File("data.csv")).settings.at("1").steps_per_mm.at("x"), 801);
}

TEST_F(SimulateCommand, GivesTheSameBytesForTheSameSeed) {
  for (const char* name : {"a.csv", "b.csv"}) {
    Simulate({File("plan.yaml"), "--fidelity", "fast", "--out", File(name)});
  }
  Simulate({File("plan.yaml"), "--fidelity=fast", "--seed=5", "--out", File("c.csv")});

  EXPECT_EQ(Read("a.csv"), Read("b.csv"));
  EXPECT_NE(Read("a.csv"), Read("c.csv"));
}

TEST_F(SimulateCommand, MeasuresTheModelThatTheMachineFileNames) {
  std::string model = ReadTextFile("models/gantry_router/model.xml", kMostBytes);
  const std::string nut = "<joint joint=\"x_nut\" coef=\"-1\"/>";
  model.replace(
      model.find(nut), nut.size(), "<joint joint=\"x_nut\" coef=\"-1.001\"/>");
  Write("model.xml", model);
  Write("machine.yaml", ReadTextFile("models/gantry_router/machine.yaml", kMostBytes));

  Simulate({File("plan.yaml"),
            "--machine",
            File("machine.yaml"),
            "--out",
            File("data.csv")});

  const Row row = ReadRows(File("data.csv")).rows[2];
  EXPECT_NEAR(row.value_mm, row.cmd_mm[0] * 1e-3, 0.004);
  EXPECT_EQ(HeaderOf(File("data.csv")).machine, "machine.yaml");
}

TEST_F(SimulateCommand, RefusesWhatIsNoPlan) {
  Write("truth.yaml", "effects: {}\n");

  EXPECT_THAT(FaultOf({File("truth.yaml"), "--out", File("data.csv")}),
              HasSubstr("this is a truth, where a plan is wanted"));
  EXPECT_THAT(FaultOf({File("plan.yaml"), "--out", File("data.txt")}),
              HasSubstr("does not end in .csv"));
  EXPECT_FALSE(fs::exists(File("data.csv")));
}

TEST_F(SimulateCommand, AsksForAMachineWhereNoneIsNamed) {
  Write("bare.yaml", "campaigns: [dense]\n");

  EXPECT_THAT(FaultOf({File("bare.yaml"), "--out", File("data.csv")}),
              HasSubstr("no machine is named"));
}

}  // namespace
}  // namespace caltwin

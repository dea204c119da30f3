// `caltwin diagnose --closed-loop` as a person uses it.
#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "sim/base/text_file.h"
#include "sim/measure/rows.h"
#include "tests/base/temp_folder.h"
#include "tests/tools/run_command.h"
#include "tools/commands/command.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr std::size_t kMostBytes = 1 << 22;

class ClosedLoopCommand : public ::testing::Test {
 protected:
  std::string File(const std::string& name) const { return (folder_ / name).string(); }

  /// `caltwin diagnose WORDS...`: what it prints.
  static std::string Diagnose(const std::vector<std::string>& words) {
    return Printed(DeclareDiagnose, words);
  }
  static std::string FaultOf(const std::vector<std::string>& words) {
    return RunCommand(DeclareDiagnose, words).fault;
  }

 private:
  TempFolder folder_{};
};

TEST_F(ClosedLoopCommand, MeasuresByItselfAndRecordsEveryRow) {
  WriteTextFile(File("truth.yaml"), "effects:\n  backlash.x: {gap_mm: 0.02}\n");

  const std::string text =
      Diagnose({"--closed-loop",
                "twin:gantry_router?fidelity=fast&truth=" + File("truth.yaml"),
                "--record",
                File("all.csv"),
                "--json",
                File("answer.json"),
                "--replay",
                "none"});

  const auto answer =
      nlohmann::json::parse(ReadTextFile(File("answer.json"), kMostBytes));
  EXPECT_THAT(text, HasSubstr("Round 1: iso230, "));
  EXPECT_EQ(answer["verdict"], "none");
  ASSERT_EQ(answer["rounds"].size(), 1U);
  EXPECT_EQ(answer["rounds"][0]["rows"], ReadRows(File("all.csv")).rows.size());
  EXPECT_TRUE(answer["replay"].is_null());
  EXPECT_THAT(Diagnose({File("all.csv"), "--replay", "none"}),
              HasSubstr("Verdict: none."));
}

TEST_F(ClosedLoopCommand, RefusesWhatCannotMeasure) {
  EXPECT_THAT(FaultOf({"--closed-loop", "tcp:localhost:8023"}),
              HasSubstr("'tcp:localhost:8023' cannot measure campaigns"));
  EXPECT_THAT(FaultOf({"--closed-loop", "gantry_router"}),
              HasSubstr("'gantry_router' is no machine"));
  EXPECT_THAT(FaultOf({}), HasSubstr("no rows to diagnose"));
}

TEST_F(ClosedLoopCommand, DoesNotRecordOverTheTruth) {
  WriteTextFile(File("data.yaml"), "effects: {}\n");

  EXPECT_THAT(FaultOf({"--closed-loop",
                       "twin:gantry_router?truth=" + File("data.yaml"),
                       "--record",
                       File("data.csv")}),
              HasSubstr("which is read: it would be written over"));
}

// Touches alone leave a leaning tower among rods and other towers; marks along x and y
// are what the diagnosis asks for, and they tell. With steps of a micrometre.
TEST_F(ClosedLoopCommand, OfADeltaMeasuresWhatHeightsCannotTell) {
  std::string machine = ReadTextFile("models/delta_printer/machine.yaml", kMostBytes);
  const std::string coarse = "microsteps: 16", model = "model: model.xml\n";
  for (std::size_t at = 0; (at = machine.find(coarse, at)) != std::string::npos;) {
    machine.replace(at, coarse.size(), "microsteps: 256");
  }
  machine.replace(machine.find(model), model.size(), "");
  WriteTextFile(File("delta.yaml"), machine);
  WriteTextFile(File("truth.yaml"),
                "effects:\n  tower_lean.b: {radial_mrad: 4, tangential_mrad: -3}\n");

  const std::string text = Diagnose(
      {"--closed-loop",
       "twin:" + File("delta.yaml") + "?fidelity=fast&truth=" + File("truth.yaml"),
       "--replay",
       "none"});

  EXPECT_THAT(text, HasSubstr("Round 1: delta_grid, "));
  EXPECT_THAT(text, HasSubstr("rows in all: ambiguous (tower_lean.b"));
  EXPECT_THAT(text, HasSubstr("Round 2: delta_xy, "));
  EXPECT_THAT(text, HasSubstr("rows in all: named (tower_lean.b)"));
}

}  // namespace
}  // namespace caltwin

// `caltwin predict`: the model of one run against another run of the same machine.
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "sim/base/text_file.h"
#include "tests/base/temp_folder.h"
#include "tests/tools/run_command.h"
#include "tools/commands/command.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

// A screw's wave and lost motion; the noise is 0.5 um.
TEST(PredictCommand, AModelTransfersToItsMachineAndToNoOther) {
  const TempFolder folder;
  const auto file = [&](const std::string& name) {
    return (folder / name).string();
  };
  const auto measure = [&](int seed,
                           const std::string& effects,
                           const std::string& to) {
    std::ofstream(file("plan.yaml"))
        << "machine: gantry_router\nseed: " << seed
        << "\ninstruments: {laser: {kind: laser, sigma_um: 0.5, resolution_um: 0.1}}\n"
           "campaigns:\n  - iso230: {axis: x}\n  - dense: {axis: x}\n";
    std::ofstream(file("truth.yaml")) << "effects: {" << effects << "}\n";
    Printed(DeclareSimulate,
            {file("plan.yaml"), "--truth", file("truth.yaml"), "--out", file(to)});
  };
  const std::string wave =
      "cyclic_lead.x: {amplitude_um: 12}, backlash.x: {gap_mm: 0.03}";
  measure(1, wave, "first.csv");
  measure(77, wave, "again.csv");
  measure(77, "", "other.csv");
  Printed(DeclareDiagnose, {file("first.csv"), "--extend", file("first.ext.yaml")});

  const auto predict = [&](const std::string& data) {
    return nlohmann::json::parse(
        Printed(DeclarePredict, {file("first.ext.yaml"), file(data), "--json", "-"}));
  };
  const nlohmann::json again = predict("again.csv"), other = predict("other.csv");
  EXPECT_TRUE(again["transfers"]);
  EXPECT_GT(again["rmse_before_um"], 6);
  EXPECT_LT(again["rmse_after_um"], 0.8);
  EXPECT_FALSE(other["transfers"]);
  EXPECT_THAT(Printed(DeclarePredict, {file("first.ext.yaml"), file("again.csv")}),
              StartsWith("Transfers: "));
}

// A real printer: its frame's growth of a morning, frozen, on the evening's log, whose
// header states a step five times too long.
TEST(PredictCommand, AMorningOfARealFrameForetellsItsEvening) {
  const TempFolder folder;
  const std::string model = (folder / "morning.ext.yaml").string();
  const std::string evening = (folder / "evening.csv").string();
  const std::string logs = "tests/data/imports/frame_log_2021-06-13_";
  Printed(DeclareDiagnose, {logs + "05-41.csv", "--replay", "none", "--extend", model});
  Printed(DeclareImport, {logs + "20-04.csv", "--step-mm", "0.0025", "--out", evening});
  const nlohmann::json told =
      nlohmann::json::parse(Printed(DeclarePredict, {model, evening, "--json", "-"}));

  EXPECT_TRUE(told["transfers"]);
  EXPECT_GT(told["rmse_before_um"], 60);
  EXPECT_LT(told["rmse_after_um"], 10);
}

TEST(PredictCommand, AMissingModelIsCalledWhatItIs) {
  const Answer answer = RunCommand(
      DeclarePredict, {"none.ext.yaml", "tests/data/iso230/ess_target_y_2022-04.csv"});
  EXPECT_THAT(answer.fault, StartsWith("MODEL: there is no machine file"));
}

TEST(PredictCommand, AMachineAsDrawnPredictsNothing) {
  const Answer answer = RunCommand(DeclarePredict,
                                   {"models/gantry_router/machine.yaml",
                                    "tests/data/iso230/ess_target_y_2022-04.csv"});
  EXPECT_THAT(answer.fault, HasSubstr("it predicts nothing beyond the drawing"));
}

}  // namespace
}  // namespace caltwin

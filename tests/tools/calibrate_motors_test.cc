#include <fstream>

#include <gmock/gmock.h>

#include "tests/base/temp_folder.h"
#include "tests/tools/run_command.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;

const std::string kStage = CALTWIN_SOURCE_DIR "/models/motor_stage/machine.yaml";

/// The stage with a gap of 0.05 mm at x.
Answer Calibrated(const std::vector<std::string>& more) {
  const TempFolder folder;
  const auto truth = folder / "truth.yaml";
  std::ofstream(truth) << "effects: {backlash.x: {gap_mm: 0.05}}\n";
  std::vector<std::string> words = {
      "--link", "twin:" + kStage + "?fidelity=fast&truth=" + truth.string()};
  words.insert(words.end(), more.begin(), more.end());
  return RunCommand(DeclareCalibrate, words);
}

TEST(CalibrateMotors, HomesAndFindsTheGapByTheTwinsLaser) {
  const Answer answer = Calibrated(
      {"--procedure", "servo_home", "--procedure", "motor_backlash", "--axis", "x"});

  EXPECT_EQ(answer.exit_code, kPassed) << answer.fault;
  EXPECT_THAT(answer.out, HasSubstr("home_offset.x"));
  EXPECT_THAT(answer.out, HasSubstr("backlash.x: 0.0"));
  EXPECT_THAT(answer.out, HasSubstr("The twin, and what it stored, is gone."));
}

TEST(CalibrateMotors, OfAMachineWantsToBeAllowed) {
  const Answer answer = RunCommand(DeclareCalibrate,
                                   {"--link",
                                    "tcp:127.0.0.1:1",
                                    "--machine",
                                    kStage,
                                    "--procedure",
                                    "servo_home: {axis: x}"});

  EXPECT_EQ(answer.exit_code, kBadInput);
  EXPECT_THAT(answer.fault, HasSubstr("home, move and store"));
}

TEST(CalibrateMotors, RefusesWhatItWouldIgnore) {
  EXPECT_THAT(Calibrated({"--procedure", "servo_home: {axis: u}"}).fault,
              HasSubstr("is an open-loop stepper"));
  EXPECT_THAT(Calibrated({"--procedure", "g33"}).fault,
              HasSubstr("is a procedure of a delta, not of a motor stage"));
  EXPECT_THAT(
      Calibrated({"--procedure", "servo_home: {axis: x}", "--record", "a.csv"}).fault,
      HasSubstr("there are no rows"));
  EXPECT_THAT(Calibrated({"--procedure", "power_cut: {}"}).fault,
              HasSubstr("a step of scenarios only"));
}

}  // namespace
}  // namespace caltwin

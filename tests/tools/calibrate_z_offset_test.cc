#include <fstream>

#include <gmock/gmock.h>

#include "scenarios/interruptible_link.h"
#include "tests/base/temp_folder.h"
#include "tests/tools/run_command.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

const std::string kStation = CALTWIN_SOURCE_DIR "/models/z_station/machine.yaml";

/// A station whose probe triggers 0.06 mm earlier than its printer.cfg says.
Answer Calibrated(const std::vector<std::string>& more,
                  const std::string& effects = "switch_offset: {off_um: 60}") {
  const TempFolder folder;
  const auto truth = folder / "truth.yaml";
  std::ofstream(truth) << "effects: {" << effects << "}\n";
  std::vector<std::string> words = {
      "--link", "twin:" + kStation + "?fidelity=fast&truth=" + truth.string()};
  words.insert(words.end(), more.begin(), more.end());
  return RunCommand(DeclareCalibrate, words);
}

// The descent finds it under the nozzle, to the feeler's leaves of 0.01 mm.
TEST(CalibrateZOffset, ADescentTellsTheSwitchOffset) {
  const Answer answer =
      Calibrated({"--procedure", "z_calibration", "--procedure", "switch_offset"});

  EXPECT_EQ(answer.exit_code, kPassed) << answer.fault;
  EXPECT_THAT(answer.out, HasSubstr("at Z0.1: a gap of 0.160 mm"));
  EXPECT_THAT(answer.out, HasSubstr("write `switch_offset: 0.560` under"));
}

TEST(CalibrateZOffset, WithoutConsentTheOffsetOfBeforeIsPutBack) {
  const TempFolder folder;
  const auto transcript = folder / "wire.txt";

  const Answer measured =
      Calibrated({"--procedure", "z_calibration", "--transcript", transcript.string()});
  const Answer applied =
      Calibrated({"--procedure", "z_calibration", "--apply", "--yes"});

  EXPECT_THAT(measured.out, HasSubstr("measured"));
  EXPECT_THAT(measured.out, HasSubstr("is put back at the end"));
  std::ifstream file(transcript);
  const std::string lines((std::istreambuf_iterator<char>(file)), {});
  EXPECT_THAT(lines, HasSubstr("SET_GCODE_OFFSET Z=0.000000"));
  EXPECT_THAT(applied.out, HasSubstr("applied"));
  EXPECT_THAT(applied.out, Not(HasSubstr("put back")));
}

// After Ctrl-C too: it moves nothing.
TEST(InterruptibleLink, LetsTheOffsetOfBeforeBePutBack) {
  EXPECT_TRUE(PutsBack("SET_GCODE_OFFSET Z=0.000000"));
  EXPECT_FALSE(PutsBack("SET_GCODE_OFFSET Z=0.000000 MOVE=1"));
  EXPECT_FALSE(PutsBack("SET_GCODE_OFFSET Z_ADJUST=0.1"));
  EXPECT_FALSE(PutsBack("CALIBRATE_Z"));
  EXPECT_TRUE(PutsBack("M425 X0.05"));
}

TEST(CalibrateZOffset, ADescentWithoutACalibrationHasNothingToGoBy) {
  const Answer answer =
      Calibrated({"--procedure", "switch_offset: {variant: as_published}"});

  EXPECT_EQ(answer.exit_code, kCheckFailed);
  EXPECT_THAT(answer.out, HasSubstr("run z_calibration first"));
}

TEST(CalibrateZOffset, RefusesWhatItWouldIgnore) {
  const std::vector<std::string> calibration = {"--procedure", "z_calibration"};
  const auto with = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = calibration;
    words.insert(words.end(), more.begin(), more.end());
    return Calibrated(words);
  };

  EXPECT_THAT(with({"--axis", "z"}).fault, HasSubstr("is along z alone"));
  EXPECT_THAT(with({"--record", "rows.csv"}).fault, HasSubstr("writes no rows"));
  EXPECT_THAT(with({"--procedure", "change: {ooze_mm: 0.1}"}).fault,
              HasSubstr("a step of scenarios only"));
  EXPECT_THAT(
      Calibrated(calibration, "station_change.nozzle: {step_um: 50, at_t_s: 10}").fault,
      HasSubstr("'station_change' needs times or a log"));
  EXPECT_THAT(
      Calibrated(calibration, "nozzle_temperature: {growth_um_per_k: 1, lag_s: 60}")
          .fault,
      HasSubstr("a lag of 'nozzle_temperature'"));
  EXPECT_THAT(
      RunCommand(DeclareCalibrate,
                 {"--link", "twin:gantry_router", "--procedure", "z_calibration"})
          .fault,
      HasSubstr("no endstop switch and magnetic probe"));
}

}  // namespace
}  // namespace caltwin

#include <filesystem>
#include <fstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include "tests/tools/run_command.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// A printer whose bed is tilted by 3 mrad along x, touched without noise.
std::string TiltedPrinter() {
  const auto truth =
      std::filesystem::path(::testing::TempDir()) /
      fmt::format("tilted_printer{}.truth.yaml", getpid());  // Tests run side by side.
  std::ofstream(truth) << "effects: {bed_tilt: {slope_x_mrad: 3}}\n";
  return "twin:" CALTWIN_SOURCE_DIR
         "/models/triple_z_printer/machine.yaml?fidelity=fast&truth=" +
         truth.string();
}

Answer Calibrated(const std::vector<std::string>& more) {
  std::vector<std::string> words = {"--link", TiltedPrinter(), "--procedure"};
  words.insert(words.end(), more.begin(), more.end());
  return RunCommand(DeclareCalibrate, words);
}

// What it says it would do, it does not.
TEST(CalibrateTripleZ, WithoutConsentItOnlyTouches) {
  const Answer answer = Calibrated({"bed_tilt"});

  EXPECT_EQ(answer.exit_code, kPassed);
  EXPECT_THAT(answer.out, HasSubstr("levelling would raise the screws by"));
  EXPECT_THAT(answer.out, Not(HasSubstr("applied. raised")));
}

TEST(CalibrateTripleZ, WithConsentTheBedIsLevelled) {
  const Answer answer = Calibrated({"bed_tilt", "--apply", "--yes"});

  EXPECT_EQ(answer.exit_code, kPassed);
  EXPECT_THAT(answer.out, HasSubstr("tilt times 0.00"));
}

TEST(CalibrateTripleZ, RefusesWhatItWouldIgnore) {
  EXPECT_THAT(Calibrated({"g33"}).fault,
              HasSubstr("is a procedure of a delta, not of a triple-Z"));
  EXPECT_THAT(Calibrated({"bed_tilt", "--record", "rows.csv"}).fault,
              HasSubstr("levelling writes no rows"));
  EXPECT_THAT(Calibrated({"bed_tilt", "--reading", "dial.x=1"}).fault,
              HasSubstr("a twin reads its own gauges"));
}

}  // namespace
}  // namespace caltwin

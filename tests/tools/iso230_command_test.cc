#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "sim/base/text_file.h"
#include "sim/base/units.h"
#include "sim/measure/rows.h"
#include "tests/base/temp_folder.h"
#include "tests/tools/run_command.h"
#include "tools/commands/command.h"
#include "tools/commands/iso230_text.h"

namespace caltwin {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;

namespace fs = std::filesystem;

/// `caltwin iso230 WORDS...`
Answer Iso230(const std::vector<std::string>& words) {
  return RunCommand(DeclareIso230, words);
}

std::string RealAxis(const std::string& name) {
  return std::string(CALTWIN_SOURCE_DIR) + "/tests/data/iso230/" + name + ".csv";
}

class Iso230Command : public ::testing::Test {
 protected:
  std::string Written(const std::string& name, const std::string& text) const {
    WriteTextFile(folder_ / name, text);
    return (folder_ / name).string();
  }

  TempFolder folder_{};
};

constexpr const char* kTwoAxes =
    "campaign,cmd_x_mm,cmd_y_mm,dir_x,dir_y,nx,ny,value_mm\n"
    "a,0,5,1,0,1,0,0.001\na,10,5,1,0,1,0,0.002\n"
    "a,5,0,0,1,0,1,0.003\na,5,10,0,1,0,1,0.004\n"
    "b,0,5,1,0,1,0,0.005\nb,10,5,1,0,1,0,0.006\n";

// The rms are those of an independent least squares over the same rows.
TEST_F(Iso230Command, PrintsTheSheetAndTheBaselineOfARealAxis) {
  const Answer answer = Iso230({RealAxis("ess_target_x_2022-04")});

  EXPECT_EQ(answer.exit_code, kPassed);
  EXPECT_THAT(answer.out,
              HasSubstr("ISO 230-2:2014, axis x, campaign iso230_x\n"
                        "9 positions from -20 to 20 mm, 5 runs a direction\n"));
  EXPECT_THAT(answer.out,
              HasSubstr("A           135.27         -  accuracy, both directions\n"));
  EXPECT_THAT(answer.out, HasSubstr("B_mean      -25.37"));
  EXPECT_THAT(answer.out, HasSubstr("U is not stated"));
  EXPECT_THAT(answer.out,
              HasSubstr("baseline: 33.0 um rms with offset and scale, 30.4 um with the "
                        "reversal\n"));
  EXPECT_THAT(answer.out, HasSubstr("note: the positions are evenly spaced"));
}

TEST_F(Iso230Command, BaselineOfTheSecondRealAxis) {
  EXPECT_THAT(Iso230({RealAxis("ess_target_y_2022-04")}).out,
              HasSubstr("baseline: 24.2 um rms with offset and scale, 23.4 um with the "
                        "reversal\n"));
}

TEST_F(Iso230Command, JsonAloneHasTheKeysOfTheContract) {
  const Answer answer = Iso230({RealAxis("ess_target_x_2022-04"), "--json", "-"});
  const auto json = nlohmann::json::parse(answer.out);

  EXPECT_EQ(json.at("format"), 1);
  EXPECT_EQ(json.at("axis"), "x");
  for (const NamedSymbol& symbol : AllIso230Symbols()) {
    EXPECT_TRUE(json.at("sheet").at(std::string(symbol.name)).is_number());
    EXPECT_TRUE(json.at("U").at(std::string(symbol.name)).is_null());
  }
  EXPECT_NEAR(json.at("sheet").at("B_mean").get<double>(), -0.0253685, 5e-8);
  ASSERT_EQ(json.at("positions").size(), 9u);
  EXPECT_EQ(json.at("positions")[0].at("target_mm"), -20);
  for (const char* key :
       {"mean_fwd_mm", "mean_bwd_mm", "s_fwd_mm", "s_bwd_mm", "B_mm"}) {
    EXPECT_TRUE(json.at("positions")[0].at(key).is_number()) << key;
  }
  bool has_backlash = false;
  for (const auto& value : json.at("baseline")) {
    if (value.at("name") != "backlash.x") continue;
    has_backlash = true;
    EXPECT_NEAR(value.at("value").get<double>(), 0.0253685, 5e-8);  // -B_mean.
    EXPECT_GT(value.at("sd").get<double>(), 0);
  }
  EXPECT_TRUE(has_backlash);
}

TEST_F(Iso230Command, TheHeadersInstrumentGivesTheUncertainty) {
  const std::string rows = Written("d.csv", kTwoAxes);
  Written("d.yaml",
          "instruments: {l: {kind: laser, sigma_um: 0.3, u_um: 1.2}, dial: {}}\n"
          "campaigns: {b: {instrument: l, plan: {iso230: {dwell_s: 4}}}}\n");
  const Answer answer =
      Iso230({rows, "--campaign", "b", "--json", "-", "--u-alignment-um", "0.5"});
  const auto u = nlohmann::json::parse(answer.out).at("U");

  // k = 2, n = 1: travel sqrt(1.2^2 + 0.5^2), two readings of 0.3.
  EXPECT_NEAR(u.at("E_fwd").get<double>(),
              MmFromUm(2 * std::hypot(1.3, 0.3 * std::sqrt(2.0))),
              1e-12);
  EXPECT_TRUE(u.at("A").is_null());
  EXPECT_THAT(Iso230({rows, "--campaign", "b"}).out,
              HasSubstr("U (k = 2) from standard uncertainties: device 1.2 um, reading "
                        "0.3 um; not stated and taken as 0: alignment, temperature, "
                        "environment\n"));
  EXPECT_THAT(Iso230({rows, "--campaign", "b"}).out, HasSubstr("dwell_s 4"));
}

TEST_F(Iso230Command, SeveralMeasurementsAreOfferedAndNoneIsGuessed) {
  const std::string rows = Written("d.csv", kTwoAxes);

  const Answer none = Iso230({rows});
  EXPECT_EQ(none.exit_code, kBadInput);
  EXPECT_EQ(none.fault,
            rows +
                ": 3 measurements stand here: choose one\n  --axis x --campaign a; "
                "--axis y --campaign a; --axis x --campaign b");
  EXPECT_EQ(none.out, "");
  EXPECT_EQ(Iso230({rows, "--axis", "y"}).exit_code, kPassed);
  EXPECT_EQ(Iso230({rows, "--campaign", "b"}).exit_code, kPassed);
  EXPECT_EQ(Iso230({rows, "--axis", "z"}).fault,
            rows +
                ": no measurement here is the one chosen\n  --axis x --campaign a; "
                "--axis y --campaign a; --axis x --campaign b");
}

TEST_F(Iso230Command, RowsOfAnotherSortAreRefused) {
  const std::string rows =
      Written("d.csv", "kind,campaign,cmd_x_mm,value_mm\ntouch,a,1,0\ntouch,a,2,0\n");

  EXPECT_THAT(Iso230({rows}).fault,
              HasSubstr("d.csv: no positioning measurement stands here"));
  EXPECT_THAT(Iso230({(folder_ / "none.csv").string()}).fault,
              EndsWith("none.csv: there is no such file"));
}

}  // namespace
}  // namespace caltwin

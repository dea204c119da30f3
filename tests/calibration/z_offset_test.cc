#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/z_offset/procedures.h"

namespace caltwin {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

// Both lines that the published page shows.
TEST(ZCalibrationReading, OfThePublishedExamplesTellsTheirSwitchOffset) {
  const auto first = ReadZCalibration(
      {"Z-CALIBRATION: ENDSTOP=-0.300 NOZZLE=-0.300 SWITCH=6.208 PROBE=7.013 --> "
       "OFFSET=-0.170"});
  const auto second =
      ReadZCalibration({"probe at 1",
                        "Z-CALIBRATION: ENDSTOP=-0.300 NOZZLE=-0.267 SWITCH=2.370 "
                        "PROBE=3.093 --> OFFSET=-0.010000"});

  ASSERT_TRUE(first && second);
  EXPECT_NEAR(first->SwitchOffset_mm(), 0.675, 1e-9);
  EXPECT_NEAR(second->SwitchOffset_mm(), 0.466, 1e-9);
  EXPECT_FALSE(ReadZCalibration({"Z-CALIBRATION: ENDSTOP=-0.300"}));
}

using Answers = std::vector<std::pair<std::string, std::string>>;

/// A wire that answers by what a line begins with.
class Script : public Link {
 public:
  explicit Script(Answers answers) : answers_(std::move(answers)) {}
  Expected<std::vector<std::string>> Send(std::string_view line,
                                          std::chrono::milliseconds) override {
    for (const auto& [start, answer] : answers_) {
      if (line.starts_with(start)) return std::vector<std::string>{answer};
    }
    return std::vector<std::string>{};
  }

 private:
  Answers answers_;
};

constexpr const char* kLine =
    "Z-CALIBRATION: ENDSTOP=-0.300 NOZZLE=-0.300 SWITCH=6.208 PROBE=7.013 --> "
    "OFFSET=-0.170000";

TEST(ZCalibration, NamesAnOffsetThatSomebodyAdjusted) {
  Script wire(
      Answers{{"CALIBRATE_Z", kLine},
              {"GET_POSITION", "gcode base: X:0.000000 Y:0.000000 Z:-0.120000"}});
  ZOffsetClient client(&wire);

  const ProcedureResult result = RunZCalibration(&client, 0.6);

  EXPECT_EQ(result.ending, Ending::kDone);
  EXPECT_THAT(result.messages,
              Contains(HasSubstr("made with switch_offset 0.675, not 0.600")));
  EXPECT_THAT(result.messages, Contains(HasSubstr("somebody adjusted it")));
}

TEST(ZCalibration, IsSpoiltByAHoming) {
  Script wire(Answers{{"CALIBRATE_Z", kLine}});
  ZOffsetClient client(&wire);

  client.Say("G28");
  client.Say("CALIBRATE_Z");
  EXPECT_FALSE(client.is_spoilt());
  client.Say("G28");
  EXPECT_TRUE(client.is_spoilt());
  client.Say("CALIBRATE_Z");
  EXPECT_FALSE(client.is_spoilt());
  client.Say("  g28 z ; again");
  EXPECT_TRUE(client.is_spoilt());
}

TEST(ZCalibration, IsSpoiltByItsOwnEnd) {
  Script wire(Answers{{"CALIBRATE_Z", kLine}});
  ZOffsetClient client(&wire, "DETACH_PROBE\nG28\n");

  client.Say("CALIBRATE_Z");

  EXPECT_TRUE(client.is_spoilt());
}

// A nozzle that hangs 0.2 mm too high everywhere wants a switch_offset greater by that.
TEST(SwitchOffset, GrowsByWhatTheNozzleHangsTooHigh) {
  Script wire(Answers{});
  ZOffsetClient client(&wire);
  std::vector<double> gaps_mm = {5.2, 3.2, 1.2, 0.7, 0.5, 0.3};
  std::size_t next = 0;

  const ProcedureResult result = RunSwitchOffset(
      &client, 0.475, [&]() -> std::optional<double> { return gaps_mm[next++]; });

  ASSERT_EQ(result.estimates.size(), 1U);
  EXPECT_NEAR(result.estimates[0].value, 0.675, 1e-9);
  EXPECT_EQ(next, gaps_mm.size());
}

TEST(SwitchOffset, StopsBeforeTheBed) {
  Script wire(Answers{});
  ZOffsetClient client(&wire);
  std::vector<double> gaps_mm = {4.3, 2.3, 0.3, -0.2, -0.4, -0.6};
  std::size_t next = 0;

  RunSwitchOffset(
      &client, 0.5, [&]() -> std::optional<double> { return gaps_mm[next++]; });

  EXPECT_EQ(next, 3U);  // From 0.3 mm half a millimetre down would be into it.
}

}  // namespace
}  // namespace caltwin

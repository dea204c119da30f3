#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/kinds/z_station/switch_offset.h"

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

// As Kalico prints it today, with its hint below.
TEST(ZCalibrationReading, OfTheFormulaTellsItsSwitchOffset) {
  const auto reading = ReadZCalibration(
      {"probe at 117.500,92.500 is z=7.080000",
       "Z-CALIBRATION: probe=7.080 - (switch=8.000 - nozzle=1.500 + "
       "switch_offset=0.500) --> new offset=0.080000",
       "HINT: z position_endstop=1.500 - offset=0.080000 --> possible z "
       "position_endstop=1.420"});

  ASSERT_TRUE(reading);
  EXPECT_NEAR(reading->offset_mm, 0.08, 1e-9);
  EXPECT_NEAR(reading->SwitchOffset_mm(), 0.5, 1e-9);
}

using Answers = std::vector<std::pair<std::string, std::string>>;

/// A wire that answers by what a line begins with.
class Script : public Link {
 public:
  explicit Script(Answers answers) : answers_(std::move(answers)) {}
  Expected<std::vector<std::string>> Send(std::string_view line,
                                          std::chrono::milliseconds) override {
    said.emplace_back(line);
    for (const auto& [start, answer] : answers_) {
      if (line.starts_with(start)) return std::vector<std::string>{answer};
    }
    return std::vector<std::string>{};
  }
  std::vector<std::string> said{};

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
  ZStationClient client(&wire);

  const ProcedureResult result = RunZCalibration(&client, 0.6);

  EXPECT_EQ(result.ending, Ending::kDone);
  EXPECT_THAT(result.messages,
              Contains(HasSubstr("made with switch_offset 0.675, not 0.600")));
  EXPECT_THAT(result.messages, Contains(HasSubstr("somebody adjusted it")));
}

TEST(ZCalibration, IsSpoiltByAHoming) {
  Script wire(Answers{{"CALIBRATE_Z", kLine}});
  ZStationClient client(&wire);

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
  ZStationClient client(&wire, {.end_gcode = "DETACH_PROBE\nG28\n"});

  client.Say("CALIBRATE_Z");

  EXPECT_TRUE(client.is_spoilt());
}

// Between the nozzle's touch and the body's the zero would be another.
TEST(ZCalibration, IsSpoiltByAHomingBeforeTheSwitch) {
  Script wire(Answers{{"CALIBRATE_Z", kLine}});
  ZStationClient client(&wire, {.before_switch_gcode = "g28 z\nATTACH_PROBE"});

  client.Say("CALIBRATE_Z");

  EXPECT_TRUE(client.is_spoilt());
}

TEST(ZCalibration, IsNotSpoiltByHomingOtherAxes) {
  Script wire(Answers{{"CALIBRATE_Z", kLine}});
  ZStationClient client(&wire, {.before_switch_gcode = "G28 X Y\nATTACH_PROBE"});

  client.Say("CALIBRATE_Z");
  client.Say("G28 X Y");

  EXPECT_FALSE(client.is_spoilt());
}

// Hands that read so much more than the height, and note how often they were asked.
struct Hands {
  double more_mm = 0;
  bool wipes = true;
  int asked = 0, wiped = 0;
  FeelerHands Give() {
    return {.gap_mm = [this](double height_mm) -> std::optional<double> {
              ++asked;
              return height_mm + more_mm;
            },
            .wipe =
                [this] {
                  ++wiped;
                  return wipes;
                }};
  }
};

// A nozzle that hangs 0.2 mm too high everywhere wants a switch_offset greater by that.
TEST(SwitchOffset, GrowsByWhatTheNozzleHangsTooHigh) {
  Script wire(Answers{{"CALIBRATE_Z", kLine}});
  ZStationClient client(&wire);
  Hands hands{.more_mm = 0.2};

  const ProcedureResult result =
      RunSwitchOffset(&client, {.in_force_mm = 0.475, .at_mm = {17, 18}}, hands.Give());

  ASSERT_EQ(result.estimates.size(), 1U);
  EXPECT_NEAR(result.estimates[0].value, 0.675, 1e-9);
  EXPECT_GT(result.estimates[0].sd, 0);
  EXPECT_EQ(hands.asked, 6);
  EXPECT_EQ(hands.wiped, 1);
  EXPECT_THAT(wire.said, Contains("G0 X17.000 Y18.000"));
}

// Three decimals of each height leave 2 um of it open.
TEST(SwitchOffset, TakesTheOneThatTheCalibrationWasMadeWith) {
  Script wire(Answers{{"CALIBRATE_Z", std::string("// ") + kLine}});
  ZStationClient client(&wire);
  Hands hands;

  const ProcedureResult result = RunSwitchOffset(&client, {}, hands.Give());

  ASSERT_EQ(result.estimates.size(), 1U);
  EXPECT_NEAR(result.estimates[0].value, 0.675, 0.002);
}

TEST(SwitchOffset, WithoutAWipedNozzleNothingIsTold) {
  Script wire(Answers{{"CALIBRATE_Z", kLine}});
  ZStationClient client(&wire);
  Hands hands{.wipes = false};

  const ProcedureResult result = RunSwitchOffset(&client, {}, hands.Give());

  EXPECT_EQ(result.ending, Ending::kRefused);
  EXPECT_TRUE(result.estimates.empty());
}

// As published it is the sum of both that is told, and said so.
TEST(SwitchOffset, AsPublishedTakesOozeAlong) {
  Script wire(Answers{{"CALIBRATE_Z", kLine}});
  ZStationClient client(&wire);
  Hands hands;
  const SwitchOffsetOptions published{.is_as_published = true};

  EXPECT_THAT(RunSwitchOffset(&client, published, hands.Give()).messages,
              Contains(HasSubstr("run z_calibration first")));
  client.Say("CALIBRATE_Z");
  const ProcedureResult result = RunSwitchOffset(&client, published, hands.Give());
  client.Say("G28");
  const ProcedureResult spoilt = RunSwitchOffset(&client, published, hands.Give());

  EXPECT_EQ(hands.wiped, 0);
  ASSERT_EQ(result.observability.size(), 1U);
  EXPECT_THAT(result.observability[0].statement,
              HasSubstr("switch_offset + ooze only"));
  EXPECT_THAT(spoilt.messages, Contains(HasSubstr("homed after CALIBRATE_Z")));
}

// Each next step is looked at before it is made, whatever the nozzle hangs too low by.
TEST(SwitchOffset, NeverEndsOnTheBed) {
  for (int hundredths = 0; hundredths < 200; ++hundredths) {
    const double low_mm = 0.01 * hundredths;
    Script wire(Answers{{"CALIBRATE_Z", kLine}});
    ZStationClient client(&wire);
    Hands hands{.more_mm = -low_mm};

    const ProcedureResult result = RunSwitchOffset(&client, {}, hands.Give());

    ASSERT_EQ(result.estimates.size(), 1U) << low_mm;
    EXPECT_NEAR(result.estimates[0].value, 0.675 - low_mm, 0.002);
  }
}

// 5.1 too large Z5 would end in the bed: it begins at Z7.
TEST(SwitchOffset, LooksAtItsFirstStepToo) {
  Script wire(Answers{{"CALIBRATE_Z", kLine}});
  ZStationClient client(&wire);
  Hands hands{.more_mm = -5.1};

  const ProcedureResult result =
      RunSwitchOffset(&client, {.in_force_mm = 5.12}, hands.Give());

  ASSERT_EQ(result.estimates.size(), 1U);
  EXPECT_NEAR(result.estimates[0].value, 0.02, 1e-9);
  EXPECT_THAT(wire.said, Contains("G0 Z7"));
  EXPECT_THAT(wire.said, ::testing::Not(Contains("G0 Z5")));
}

/// Hands that type that gap at a height, so often.
struct MistypingHands {
  double at_mm = 0, gap_mm = 0;
  int times = 1;
  FeelerHands Give() {
    return {.gap_mm = [this](double height_mm) -> std::optional<double> {
              return height_mm == at_mm && times-- > 0 ? gap_mm : height_mm + 0.05;
            },
            .wipe =
                [] {
                  return true;
                }};
  }
};

// 1.15 for 0.15: the nozzle went down, and the gap grew.
TEST(SwitchOffset, AGapThatContradictsTheOneAboveIsMeasuredOnceMore) {
  Script wire(Answers{{"CALIBRATE_Z", kLine}});
  ZStationClient client(&wire);
  MistypingHands once{.at_mm = 0.1, .gap_mm = 1.15};
  MistypingHands twice{.at_mm = 3, .gap_mm = 0.1, .times = 2};

  const ProcedureResult mended = RunSwitchOffset(&client, {}, once.Give());
  const ProcedureResult refused = RunSwitchOffset(&client, {}, twice.Give());

  ASSERT_EQ(mended.estimates.size(), 1U);
  EXPECT_NEAR(mended.estimates[0].value, 0.725, 0.002);
  EXPECT_THAT(mended.messages, Contains(HasSubstr("measured once more")));
  EXPECT_EQ(refused.ending, Ending::kRefused);
  EXPECT_TRUE(refused.estimates.empty());
  EXPECT_THAT(refused.fault, HasSubstr("the gaps contradict each other"));
}

// Toolhead less gcode, as GET_POSITION has them.
TEST(SwitchOffset, WhatAMeshAddsThereIsTakenOff) {
  class Meshed : public Link {
   public:
    Expected<std::vector<std::string>> Send(std::string_view line,
                                            std::chrono::milliseconds) override {
      if (line == "CALIBRATE_Z") return std::vector<std::string>{kLine};
      if (line != "GET_POSITION") return std::vector<std::string>{};
      return std::vector<std::string>{"toolhead: X:0.0 Y:0.0 Z:4.630 E:0.0",
                                      "gcode: X:0.0 Y:0.0 Z:4.830 E:0.0",
                                      "gcode base: X:0.0 Y:0.0 Z:-0.170 E:0.0"};
    }
  };
  Meshed wire;
  ZStationClient client(&wire);
  Hands hands{.more_mm = -0.2};

  const ProcedureResult result = RunSwitchOffset(&client, {}, hands.Give());

  ASSERT_EQ(result.estimates.size(), 1U);
  EXPECT_NEAR(result.estimates[0].value, 0.675, 0.002);
  EXPECT_THAT(result.messages,
              Contains(HasSubstr("the bed mesh moves the nozzle by -0.200 mm")));
}

// Calibrations that scatter make what is told as uncertain.
TEST(SwitchOffset, IsAsUncertainAsCalibrationsScatter) {
  class Scattering : public Link {
   public:
    Expected<std::vector<std::string>> Send(std::string_view line,
                                            std::chrono::milliseconds) override {
      if (line != "CALIBRATE_Z") return std::vector<std::string>{};
      const double off_mm = 0.01 * (calls++ % 3 - 1);
      return std::vector<std::string>{
          ZCalibrationText(-0.3, 6.208, 7.013 + off_mm, 7.013 + off_mm - 7.183)};
    }
    int calls = 0;

   private:
    static std::string ZCalibrationText(double nozzle_mm,
                                        double switch_mm,
                                        double probe_mm,
                                        double offset_mm) {
      return fmt::format(
          "Z-CALIBRATION: ENDSTOP=-0.300 NOZZLE={:.3f} SWITCH={:.3f} PROBE={:.3f} --> "
          "OFFSET={:.6f}",
          nozzle_mm,
          switch_mm,
          probe_mm,
          offset_mm);
    }
  } wire;
  ZStationClient client(&wire);
  Hands hands;

  const ProcedureResult result = RunSwitchOffset(&client, {}, hands.Give());

  // -10 0 +10 -10 0 um: sd 8.4 um, a mean of five of them 3.7, k of four degrees.
  ASSERT_EQ(result.estimates.size(), 1U);
  EXPECT_GT(result.estimates[0].sd, 0.0045);
  EXPECT_LT(result.estimates[0].sd, 0.0075);
  // The last was 2 um higher than their mean.
  EXPECT_NEAR(result.estimates[0].value, 0.675 - 0.002, 1e-3);
}

TEST(ZCalibration, FiguresThatAreNoneOrContradictEachOtherAreRefused) {
  for (const char* line :
       {"Z-CALIBRATION: ENDSTOP=-0.300 NOZZLE=nan SWITCH=6.208 PROBE=7.013 --> "
        "OFFSET=-0.170",
        "Z-CALIBRATION: ENDSTOP=-0.300 NOZZLE=-0.300 SWITCH=6.208 PROBE=7.013 --> "
        "OFFSET=inf",
        "Z-CALIBRATION: ENDSTOP=-0.300 NOZZLE=-0.300 SWITCH=6.208 PROBE=7.013 --> "
        "OFFSET=5.000"}) {
    Script wire(Answers{{"CALIBRATE_Z", line}});
    ZStationClient client(&wire);

    EXPECT_EQ(RunZCalibration(&client, std::nullopt).ending, Ending::kRefused) << line;
  }
}

TEST(SwitchOffset, AGapThatIsNoneIsRefused) {
  Script wire(Answers{{"CALIBRATE_Z", kLine}});
  ZStationClient client(&wire);
  Hands hands{.more_mm = -6};

  EXPECT_THAT(RunSwitchOffset(&client, {}, hands.Give()).messages,
              Contains(HasSubstr("the nozzle is on the bed")));
}

}  // namespace
}  // namespace caltwin

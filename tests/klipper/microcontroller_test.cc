#include "sim/controllers/klipper/microcontroller.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <zlib.h>

#include "sim/base/rng.h"
#include "tests/klipper/host.h"

namespace caltwin {
namespace klipper {
namespace {

using testing::ElementsAre;
using testing::Optional;

constexpr Clock kStart = 10 * kTicksPerSecond;
enum Oid { kStepper, kSync, kEndstop, kOutput, kAnalog, kNumOids };

/// A chip that was configured and has been on for ten seconds.
class Klipper : public testing::Test {
 protected:
  Klipper() {
    host_.At(kStart);
    host_.Send("allocate_oids", {kNumOids});
    host_.Send("config_stepper", {kStepper, 0, 1, 0, 100});
    host_.Send("config_trsync", {kSync});
    host_.Send("config_endstop", {kEndstop, 2, 1});
    host_.Send("config_digital_out", {kOutput, 1, 0, 0, 1000});
    host_.Send("config_analog_in", {kAnalog, 3});
    host_.Send("finalize_config", {4711});
  }

  /// 200 steps up, one in 1000 ticks, from a thousand ticks on.
  void GoUp() {
    host_.Send("reset_step_clock", {kStepper, kStart});
    host_.Send("set_next_step_dir", {kStepper, 1});
    host_.Send("queue_step", {kStepper, 1000, 200, 0});
  }
  void Watch(std::int64_t samples) {
    host_.Send("trsync_start", {kSync, kStart + 50'000, 50'000, 4});
    host_.Send("stepper_stop_on_trigger", {kStepper, kSync});
    host_.Send("endstop_home", {kEndstop, kStart + 7, 10, samples, 300, 1, kSync, 1});
  }

  ToyBoard board_{};
  Microcontroller chip_{&board_};
  ToyHost host_{&chip_};
};

TEST_F(Klipper, SaysThatItIsConfigured) {
  host_.Send("get_config");
  host_.Send("get_uptime");
  EXPECT_THAT(host_.Said("config"), ElementsAre(ElementsAre(1, 4711, 0, kMoveCount)));
  EXPECT_THAT(host_.Said("uptime"), ElementsAre(ElementsAre(0, kStart)));
  EXPECT_EQ(host_.num_acknowledged(), 9);
}

TEST_F(Klipper, TheEndstopStopsTheMotorAtTheSampleBehindTheStep) {
  Watch(/*samples=*/4);
  GoUp();
  host_.At(kStart + kTicksPerSecond);
  // Step 100 falls at 100000; samples at 7 + 300 n: the first from there on, S, is
  // 100207, and is confirmed by three more, 10 ticks apart. Step 101 would fall later.
  constexpr Clock kSample = kStart + 100'207;
  host_.Send("endstop_query_state", {kEndstop});
  EXPECT_THAT(host_.Said("endstop_state"),
              ElementsAre(ElementsAre(kEndstop, 0, kSample + 300, 1)));
  host_.Send("stepper_get_position", {kStepper});
  EXPECT_THAT(host_.Said("stepper_position"), ElementsAre(ElementsAre(kStepper, 100)));
  EXPECT_EQ(board_.at, 100);
  EXPECT_EQ(board_.armed, 1);
  const auto states = host_.Said("trsync_state");
  ASSERT_EQ(states.size(), 3U);  // At 50000 and 100000, and of the trigger.
  EXPECT_THAT(states[0], ElementsAre(kSync, 1, 0, kStart + 50'000));
  EXPECT_THAT(states[2], ElementsAre(kSync, 0, 1, 0));
}

TEST_F(Klipper, AFrozenMotorTakesNoStepsUntilItsClockIsReset) {
  Watch(/*samples=*/1);
  GoUp();
  host_.At(kStart + 150'000);
  host_.Send("queue_step", {kStepper, 60'000, 5, 0});
  host_.At(kStart + kTicksPerSecond);
  EXPECT_EQ(board_.at, 100);
  host_.Send("reset_step_clock", {kStepper, kStart + kTicksPerSecond});
  host_.Send("queue_step", {kStepper, 1000, 5, 0});  // The direction is down again.
  host_.At(kStart + 2 * kTicksPerSecond);
  EXPECT_EQ(board_.at, 95);
}

TEST_F(Klipper, ABounceShorterThanTheSamplesIsNoTrigger) {
  board_.closes_at = 100;
  board_.opens_at = 101;   // High for 1000 ticks.
  Watch(/*samples=*/200);  // 2000 ticks.
  GoUp();
  host_.At(kStart + 100'500);  // A look at it while it is high.
  host_.At(kStart + kTicksPerSecond);
  EXPECT_EQ(board_.at, 200);
}

TEST_F(Klipper, StopsWhenTheHostFallsSilent) {
  Watch(/*samples=*/1);
  host_.Send("trsync_set_timeout", {kSync, kStart + 20'500});
  GoUp();
  host_.At(kStart + kTicksPerSecond);
  EXPECT_EQ(board_.at, 20);
  EXPECT_THAT(host_.Said("trsync_state"), ElementsAre(ElementsAre(kSync, 0, 4, 0)));
}

TEST_F(Klipper, StepsInThePastShutItDown) {
  host_.Send("reset_step_clock", {kStepper, kStart - 5000});
  host_.Send("queue_step", {kStepper, 1000, 5, 0});
  EXPECT_THAT(chip_.shutdown(), Optional(std::string_view("Timer too close")));
  EXPECT_THAT(host_.Said("shutdown"), ElementsAre(ElementsAre(kStart, 1)));
  host_.Send("stepper_get_position", {kStepper});
  EXPECT_THAT(host_.Said("is_shutdown"), ElementsAre(ElementsAre(1)));
}

TEST_F(Klipper, AnOutputThatNobodyRenewsShutsItDown) {
  host_.Send("queue_digital_out", {kOutput, kStart + 100, 1});
  host_.At(kStart + 1099);
  EXPECT_EQ(chip_.shutdown(), std::nullopt);
  host_.At(kStart + 1100);
  EXPECT_THAT(
      chip_.shutdown(),
      Optional(std::string_view("Missed scheduling of next digital out event")));
}

TEST_F(Klipper, AReadingOutOfItsRangeShutsItDownTheThirdTime) {
  host_.Send("query_analog_in", {kAnalog, kStart + 100, 10, 4, 5000, 0, 8000, 3});
  host_.At(kStart + 10'000);
  EXPECT_EQ(chip_.shutdown(), std::nullopt);
  host_.At(kStart + 10'100);
  // Half of 4095, to the nearest, four times.
  EXPECT_EQ(host_.Said("analog_in_state").front()[2], 4 * 2048);
  EXPECT_THAT(chip_.shutdown(), Optional(std::string_view("ADC out of range")));
}

TEST_F(Klipper, AResetForgetsItsConfigurationButNotWhereTheMachineStands) {
  GoUp();
  host_.At(kStart + kTicksPerSecond);
  host_.Send("emergency_stop");
  host_.Send("config_reset");
  host_.Send("get_config");
  EXPECT_THAT(host_.Said("config"), ElementsAre(ElementsAre(0, 0, 0, kMoveCount)));
  EXPECT_EQ(chip_.MotorsAt(chip_.now())[0], 200);
}

TEST_F(Klipper, ADamagedBlockIsAskedForAgain) {
  const Bytes lost = BlockOf(10, Bytes{2});  // get_uptime would be the eighth.
  chip_.Receive(lost);
  const Bytes answer = chip_.TakeOutput();
  EXPECT_EQ(answer, BlockOf(8, {}));
}

TEST(KlipperDictionary, IsWhatTheHostUnpacks) {
  ToyBoard board;
  const Bytes packed = CompressedDictionary(board);
  Bytes text(20'000);
  uLongf size = text.size();
  ASSERT_EQ(uncompress(text.data(), &size, packed.data(), packed.size()), Z_OK);
  const auto dictionary =
      nlohmann::json::parse(text.begin(), text.begin() + static_cast<int>(size));
  EXPECT_EQ(dictionary["commands"]["identify offset=%u count=%c"], 1);
  EXPECT_EQ(dictionary["responses"]["identify_response offset=%u data=%.*s"], 0);
  EXPECT_EQ(dictionary["config"]["CLOCK_FREQ"], kTicksPerSecond);
  EXPECT_EQ(dictionary["enumerations"]["pin"]["SWITCH"], 2);
  EXPECT_EQ(dictionary["enumerations"]["static_string_id"]["Timer too close"], 1);
}

TEST(KlipperMicrocontroller, AnyBytesAreSurvived) {
  Rng rng(4, 0, "klipper.bytes");
  for (int round = 0; round < 100; ++round) {
    ToyBoard board;
    Microcontroller chip(&board);
    chip.Advance(kStart);
    for (int sequence = 1; sequence < 30; ++sequence) {
      Bytes payload;
      const auto length = static_cast<std::size_t>(rng.Uniform() * 20);
      for (std::size_t i = 0; i < length; ++i) {
        payload.push_back(static_cast<std::uint8_t>(rng.Uniform() * 128));
      }
      chip.Receive(BlockOf(sequence, payload));
      chip.Advance(chip.now() + 1000);
    }
    EXPECT_GE(chip.TakeOutput().size(), 29 * kShortestBlock);
  }
}

TEST(KlipperFormats, EveryCommandComesBackAsItWent) {
  for (const MessageFormat& format : Commands()) {
    std::vector<Argument> sent;
    for (const Parameter& parameter : format.parameters) {
      sent.emplace_back(parameter.is_signed ? -5
                                            : (std::int64_t{1} << parameter.bits) - 2);
    }
    Bytes payload;
    AppendMessage(format, sent, &payload);
    ByteView view = payload;
    const auto taken = TakeCommand(&view);
    ASSERT_TRUE(taken) << format.text;
    EXPECT_EQ(taken->format->name, format.name);
    for (std::size_t i = 0; i < sent.size(); ++i) {
      EXPECT_EQ(taken->arguments[i].number, sent[i].number) << format.text;
    }
    EXPECT_TRUE(view.empty());
  }
}

}  // namespace
}  // namespace klipper
}  // namespace caltwin

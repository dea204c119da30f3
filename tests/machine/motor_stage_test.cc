#include <fstream>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "sim/base/input_error.h"
#include "sim/machine/kinds/kinds.h"
#include "sim/machine/kinds/motor_stage/drawing.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;

const std::filesystem::path kFile =
    CALTWIN_SOURCE_DIR "/models/motor_stage/machine.yaml";

std::filesystem::path Written(const std::string& text) {
  const auto file = std::filesystem::path(::testing::TempDir()) /
                    ("motor_stage_test" + std::to_string(getpid()) + ".yaml");
  std::ofstream(file) << text;
  return file;
}

std::string FaultOf(const std::string& text) {
  try {
    ReadMachine(Written(text));
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(MotorStage, HasFourServosOneOfThemRotaryAndTwoSteppers) {
  const MotorStageDrawing stage = MotorStageOf(ReadMachine(kFile));

  int servos = 0, rotary = 0;
  for (const MotorAxisDrawing& axis : stage.axes) {
    servos += axis.is_servo ? 1 : 0;
    rotary += axis.is_rotary ? 1 : 0;
  }
  EXPECT_EQ(servos, 4);
  EXPECT_EQ(rotary, 1);
  EXPECT_EQ(ReadMachine(kFile).kind, MotorStageKind());
}

TEST(MotorStage, CountsPulsesPerDegreeOfARotaryAxis) {
  const MotorStageDrawing stage = MotorStageOf(ReadMachine(kFile));
  const MotorAxisDrawing& a = stage.axes[*MotorAxisNamed("a")];

  EXPECT_DOUBLE_EQ(a.pulses_per_unit(), 10'000.0 / 4);
  EXPECT_DOUBLE_EQ(a.si_per_unit(), std::numbers::pi / 180);
  EXPECT_STREQ(a.unit(), "deg");
}

TEST(MotorStage, RefusesLimitsBeyondTheSwitchesAndMillimetresOfARotaryAxis) {
  EXPECT_THAT(
      FaultOf("kinematics: motor_stage\nmodel: none.xml\n"
              "axes: {x: {min_mm: -20}, a: {min_mm: 3}}\n"),
      AllOf(HasSubstr("'none.xml': there is no such file"),
            HasSubstr("axes.x: min_switch = -8, min = -20, max = 200, max_switch "
                      "= 208 do not rise"),
            HasSubstr("axes.a has no key 'min_mm'")));
}

TEST(MotorStage, AxesHaveNamesOfOneLetter) {
  EXPECT_EQ(MotorAxisNamed("v"), 5U);
  EXPECT_FALSE(MotorAxisNamed("b"));
  EXPECT_FALSE(MotorAxisNamed("xy"));
  EXPECT_FALSE(MotorAxisNamed(""));
}

}  // namespace
}  // namespace caltwin

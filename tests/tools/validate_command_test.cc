#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/tools/caltwin_process.h"

namespace caltwin {
namespace {

using ::testing::AllOf;
using ::testing::Eq;
using ::testing::HasSubstr;

constexpr const char* kScenario =
    "machine: gantry_router\n"
    "calibrate: [gcode: {lines: [M114]}]\n";

TEST(Validate, TellsTheKindByTheTopLevelKey) {
  const std::string truth =
      Written("t.yaml", "effects: {backlash.x: {gap_mm: 0.05}}\n");

  const Finished run = Caltwin("validate models/gantry_router/machine.yaml " + truth +
                               " " + Written("good.yaml", kScenario));

  EXPECT_THAT(run.code, Eq(0));
  EXPECT_THAT(run.out,
              AllOf(HasSubstr("machine.yaml: machine, no faults\n"),
                    HasSubstr("t.yaml: truth, no faults\n"),
                    HasSubstr("good.yaml: scenario, no faults\n")));
}

// Each with its place; of another kind's reader the message would be about effects.
TEST(Validate, AFaultyTruthIsToldAsOfItsOwnKind) {
  struct Case {
    const char *text, *fault;
  };
  for (const Case& one :
       {Case{"effects: {backlash.x: {gap: 0.05}}\n", "effects.backlash.x has no key"},
        Case{"effects: {rod_mismatch.a1: {length_error: 1}}\n",
             "effects.rod_mismatch.a1 has no key"},
        Case{"effects: {pivot_position.z1: {dx: 1}}\n",
             "effects.pivot_position.z1 has no key"},
        Case{"effects: {ooze: {thickness: 1}}\n", "effects.ooze has no key"},
        Case{"effects: {switch_scatter.x: {sd: 1}}\n",
             "effects.switch_scatter.x has no key"}}) {
    const Finished run = Caltwin("validate " + Written("t.yaml", one.text));
    EXPECT_THAT(run.code, Eq(2));
    EXPECT_THAT(run.err, HasSubstr(one.fault));
    EXPECT_THAT(run.err, HasSubstr("t.yaml:1:"));
  }
}

TEST(Validate, AFileOfNoKindSaysWhichKeysTell) {
  const Finished run = Caltwin("validate " + Written("odd.yaml", "colour: red\n"));

  EXPECT_THAT(run.code, Eq(2));
  EXPECT_THAT(run.err, HasSubstr("no key tells what this file is for"));
}

}  // namespace
}  // namespace caltwin

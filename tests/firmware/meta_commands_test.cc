#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/firmware/bench.h"

namespace caltwin {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// Writes a macro and runs it.
std::vector<std::string> RunMacro(const std::string& text,
                                  const std::string& words = "") {
  FirmwareBench bench;
  bench.firmware.WriteFile("sys/test.g", text);
  return bench.Say({R"(M98 P"test.g" )" + words});
}

std::string Evaluated(const std::string& expression) {
  FirmwareBench bench;
  const auto printed = bench.Say({"echo " + expression});
  return printed.empty() ? "" : printed.front();
}

TEST(MetaCommands, ExpressionsBindAsInTheManual) {
  EXPECT_EQ(Evaluated("1 + 2 * 3"), "7");
  EXPECT_EQ(Evaluated("(1 + 2) * -3"), "-9");
  EXPECT_EQ(Evaluated("7 / 2"), "3.5");
  EXPECT_EQ(Evaluated("mod(7, 3)"), "1");
  EXPECT_EQ(Evaluated("1 + 1 = 2 && !(3 < 2)"), "true");
  EXPECT_EQ(Evaluated(R"("a" ^ 1 + 1 ^ "b")"), "a2b");
  EXPECT_EQ(Evaluated("3 > 2 ? 10 : 20"), "10");
  EXPECT_EQ(Evaluated("#{1,2,3}"), "3");
  EXPECT_EQ(Evaluated("{0.02, 0.5, 3}[1]").substr(0, 5), "Error");
  EXPECT_EQ(Evaluated("vector(3, 0.5)"), "{0.5,0.5,0.5}");
  EXPECT_EQ(Evaluated("abs(-2.5) + max(1, 2, 3) + sqrt(16)"), "9.5");
  EXPECT_EQ(Evaluated("degrees(atan2(1, 1))"), "45");
}

TEST(MetaCommands, WhatIsNotChosenIsNotEvaluated) {
  EXPECT_EQ(Evaluated("exists(global.none) ? global.none : 5"), "5");
  EXPECT_EQ(Evaluated("exists(global.none) && global.none > 1"), "false");
  EXPECT_EQ(Evaluated("true || global.none"), "true");
}

TEST(MetaCommands, FaultsNameTheCulprit) {
  EXPECT_EQ(Evaluated("global.none"), "Error: meta command: unknown variable 'none'");
  EXPECT_EQ(Evaluated("move.nothing"),
            "Error: meta command: unknown value 'move.nothing'");
  EXPECT_EQ(Evaluated("frobnicate(1)"),
            "Error: meta command: unknown function 'frobnicate'");
}

TEST(MetaCommands, BranchesFollowTheIndentation) {
  const std::string macro =
      "if param.A = 1\n"
      "  echo \"one\"\n"
      "elif param.A = 2\n"
      "  if true\n"
      "    echo \"two\"\n"
      "  else\n"
      "    echo \"never\"\n"
      "else\n"
      "  echo \"many\"\n"
      "echo \"end\"\n";

  EXPECT_THAT(RunMacro(macro, "A1"), ElementsAre("one", "end"));
  EXPECT_THAT(RunMacro(macro, "A2"), ElementsAre("two", "end"));
  EXPECT_THAT(RunMacro(macro, "A3"), ElementsAre("many", "end"));
}

TEST(MetaCommands, LoopsCountBreakAndContinue) {
  EXPECT_THAT(RunMacro("var sum = 0\n"
                       "while iterations < 10\n"
                       "  if iterations = 2\n"
                       "    continue\n"
                       "  if iterations = 5\n"
                       "    break\n"
                       "  while iterations < 2\n"
                       "    set var.sum = var.sum + 1\n"
                       "  echo iterations\n"
                       "echo var.sum\n"),
              ElementsAre("0", "1", "3", "4", "8"));
}

TEST(MetaCommands, LoopThatNeverEndsIsStopped) {
  EXPECT_THAT(RunMacro("while true\n  G4 P0\n"),
              ElementsAre(HasSubstr("the macro does not end")));
}

TEST(MetaCommands, MacroCallingItselfIsStopped) {
  EXPECT_THAT(RunMacro("M98 P\"test.g\"\n"), ElementsAre(HasSubstr("too many macros")));
}

TEST(MetaCommands, CommandsTakeExpressions) {
  FirmwareBench bench;
  bench.HomeAndCentre();

  bench.Say({"global nxtGap = 0.05",
             "M425 X{global.nxtGap * 2}",
             "G1 X{move.axes[0].max - 5} F6000",
             "M400"});

  EXPECT_DOUBLE_EQ(bench.firmware.settings().backlash_mm[0], 0.1);
  EXPECT_DOUBLE_EQ(bench.firmware.position_mm()[0], 295);
}

TEST(MetaCommands, UserFilesBecomeCommands) {
  FirmwareBench bench;
  bench.firmware.WriteFile("sys/G6512.g", "echo \"probing to\", param.X\n");

  EXPECT_THAT(bench.Say({"G6512 X12.5 I0"}), ElementsAre("probing to 12.5"));
}

TEST(MetaCommands, AbortEndsAllMacros) {
  FirmwareBench bench;
  bench.firmware.WriteFile("sys/inner.g", "abort \"no probe\"\necho \"inner\"\n");
  bench.firmware.WriteFile("sys/outer.g", "M98 P\"inner.g\"\necho \"outer\"\n");

  EXPECT_THAT(bench.Say({R"(M98 P"outer.g")"}),
              ElementsAre("Error: in file macro line 1: no probe"));
}

TEST(UserVars, UnguardedGlobalFailsOnTheSecondLoad) {
  FirmwareBench bench;
  bench.firmware.WriteFile("sys/nxt-user-vars.g",
                           "M92 X800.1\nglobal nxtProbeDeflection = 0.025\n");

  EXPECT_THAT(bench.Say({"M999"}), IsEmpty());
  EXPECT_EQ(bench.firmware.settings().probe_deflection_mm[1], 0.025);
  EXPECT_THAT(bench.Say({R"(M98 P"nxt-user-vars.g")"}),
              ElementsAre("Error: in file macro line 2: meta command: variable "
                          "'nxtProbeDeflection' already exists"));
}

TEST(UserVars, GuardedGlobalLoadsTwice) {
  FirmwareBench bench;
  bench.firmware.WriteFile("sys/nxt-user-vars.g",
                           "if !exists(global.nxtProbeDeflection)\n"
                           "  global nxtProbeDeflection = {0.02, 0.021, 0.019}\n"
                           "else\n"
                           "  set global.nxtProbeDeflection = {0.02, 0.021, 0.019}\n");

  EXPECT_THAT(bench.Say({"M999", R"(M98 P"nxt-user-vars.g")"}), IsEmpty());
  EXPECT_THAT(bench.Say({"echo global.nxtProbeDeflection"}),
              ElementsAre("{0.02,0.021,0.019}"));
  EXPECT_EQ(bench.firmware.settings().probe_deflection_mm[2], 0.019);
}

TEST(UserVars, StartUpRunsThem) {
  FirmwareBench bench({.files = {{"sys/nxt-user-vars.g", "M92 X808\nM425 Y0.1\n"}}});

  EXPECT_EQ(bench.firmware.settings().steps_per_mm[0], 808);
  EXPECT_EQ(bench.firmware.settings().backlash_mm[1], 0.1);
}

TEST(UserVars, ConfiguredDeflectionIsAGlobal) {
  FirmwareBench bench;

  EXPECT_THAT(bench.Say({"set global.nxtProbeDeflection[1] = 0.03",
                         "set global.nxtProbeTipRadius = 1.5",
                         "echo global.nxtProbeDeflection"}),
              ElementsAre("{0,0.03,0}"));
  EXPECT_EQ(bench.firmware.settings().probe_deflection_mm[1], 0.03);
  EXPECT_EQ(bench.firmware.settings().tip_radius_mm, 1.5);
}

TEST(Storage, EchoWritesAndAppends) {
  FirmwareBench bench;
  bench.Say({R"(echo >"0:/sys/a.g" "first", 1 + 1)",
             R"(echo >>"a.g" "second")",
             R"(echo >>>"/sys/a.g" "third")"});

  EXPECT_EQ(bench.firmware.files().at("sys/a.g"), "first 2\nsecond\nthird");
}

}  // namespace
}  // namespace caltwin

#include <array>
#include <cstdio>
#include <filesystem>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "sim/base/text_file.h"
#include "tests/tools/caltwin_process.h"
#include "tools/commands/command.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;

using ::testing::AllOf;
using ::testing::Eq;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;
using ::testing::StrEq;

constexpr const char* kPassing =
    "about: A gap, put right by hand.\n"
    "machine: gantry_router\n"
    "fidelity: fast\n"
    "effects: {backlash.x: {gap_mm: 0.05}}\n"
    "calibrate: [gcode: {lines: [M425 X0.05]}]\n"
    "expect: {backlash.x: {truth_within: 0.001}}\n";

std::string Failing() {
  std::string text = kPassing;
  return text.replace(text.find("M425 X0.05"), 10, "M425 X0.02");
}

TEST(CommandLine, APassedRunExitsWithZeroAndPrintsATable) {
  const Finished run = Caltwin("run " + Written("good.yaml", kPassing));

  EXPECT_THAT(run.code, Eq(0));
  EXPECT_THAT(run.out,
              AllOf(HasSubstr("injected  recovered"), HasSubstr("PASSED: 2 of 2")));
  EXPECT_THAT(run.err, IsEmpty());
}

TEST(CommandLine, AFailedExpectationExitsWithOne) {
  const Finished run = Caltwin("run " + Written("bad.yaml", Failing()));

  EXPECT_THAT(run.code, Eq(1));
  EXPECT_THAT(run.out, HasSubstr("MISSED"));
}

TEST(CommandLine, JsonOnStdoutStandsAlone) {
  const Finished run = Caltwin("run " + Written("good.yaml", kPassing) + " --json -");

  const auto json = nlohmann::json::parse(run.out);
  EXPECT_THAT(json["format"], Eq(1));
  EXPECT_THAT(json["passed"], Eq(true));
  EXPECT_THAT(json["outcome"], Eq("recovers"));
  EXPECT_THAT(json["fidelity"], Eq("fast"));
  EXPECT_THAT(json["seed"], Eq(1));
  const auto& row = json["parameters"][0];
  EXPECT_THAT(row["name"], Eq("backlash.x"));
  EXPECT_THAT(row["unit"], Eq("mm"));
  EXPECT_THAT(row["injected"], Eq(0.05));
  EXPECT_THAT(row["source"], Eq("setting"));
  EXPECT_THAT(row["tolerance"], Eq(0.001));
  EXPECT_THAT(row["sd"], Eq(nullptr));
  for (const char* key :
       {"steps", "observability", "machine_time_s", "cpu_s", "touches", "scenario"}) {
    EXPECT_TRUE(json.contains(key)) << key;
  }
}

TEST(CommandLine, SeveralRunsGetALineEachAndASummary) {
  const std::string files =
      Written("good.yaml", kPassing) + " " + Written("bad.yaml", Failing());

  const Finished run = Caltwin("run " + files);
  const Finished json = Caltwin("run " + files + " --json -");

  EXPECT_THAT(run.code, Eq(1));
  EXPECT_THAT(run.out, HasSubstr("2 runs, 1 passed (50.0 %)"));
  const auto tree = nlohmann::json::parse(json.out);
  EXPECT_THAT(tree["runs"].size(), Eq(2u));
  EXPECT_THAT(tree["passed"], Eq(1));
  EXPECT_THAT(tree["coverage95"], Eq(nullptr));
}

TEST(CommandLine, SeedsCountFromTheFirst) {
  const Finished run =
      Caltwin("run " + Written("good.yaml", kPassing) + " --seed 5 --seeds 3 --json -");

  const auto tree = nlohmann::json::parse(run.out);
  ASSERT_THAT(tree["runs"].size(), Eq(3u));
  EXPECT_THAT(tree["runs"][0]["seed"], Eq(5));
  EXPECT_THAT(tree["runs"][2]["seed"], Eq(7));
}

TEST(CommandLine, WritesJsonAndJUnitFiles) {
  const fs::path json = Scratch() / "new_folder" / "result.json";
  const fs::path junit = Scratch() / "result.xml";

  Caltwin(fmt::format("run {} --json {} --junit {}",
                      Written("good.yaml", kPassing),
                      json.string(),
                      junit.string()));

  EXPECT_TRUE(nlohmann::json::parse(ReadTextFile(json, 1'000'000))["passed"]);
  EXPECT_THAT(
      ReadTextFile(junit, 1'000'000),
      HasSubstr("<testcase classname=\"good\" name=\"backlash.x\" time=\"0\"/>"));
}

struct BadInput {
  const char* name;
  const char* text;
  const char* message;  // Behind the file's name.
};
class BadFile : public ::testing::TestWithParam<BadInput> {};

TEST_P(BadFile, ExitsWithTwoAndOneMessage) {
  const std::string file =
      Written(fmt::format("{}.yaml", GetParam().name), GetParam().text);
  const fs::path json = Scratch() / fmt::format("{}.json", GetParam().name);

  const Finished run = Caltwin(fmt::format("run {} --json {}", file, json.string()));

  EXPECT_THAT(run.code, Eq(2));
  EXPECT_THAT(run.out, IsEmpty());
  EXPECT_THAT(run.err, StartsWith(file + GetParam().message));
  EXPECT_FALSE(fs::exists(json));
}

INSTANTIATE_TEST_SUITE_P(
    ,
    BadFile,
    ::testing::Values(
        BadInput{
            "unknown_key",
            "machine: gantry_router\nsed: 1\ncalibrate: [gcode: {lines: [M114]}]\n",
            ":2:1: this file has no key 'sed'\n  did you mean 'seed'?"},
        BadInput{
            "wrong_type",
            "machine: gantry_router\nseed: x\ncalibrate: [gcode: {lines: [M114]}]\n",
            ":2:7: seed = 'x' is not a whole number\n"},
        BadInput{"out_of_range",
                 "machine: gantry_router\neffects: {backlash.x: {gap_mm: -1}}\n"
                 "calibrate: [gcode: {lines: [M114]}]\n",
                 ":2:32: effects.backlash.x.gap_mm = -1 is outside 0 .. 5\n"},
        BadInput{"not_a_number",
                 "machine: gantry_router\neffects: {backlash.x: {gap_mm: nan}}\n"
                 "calibrate: [gcode: {lines: [M114]}]\n",
                 ":2:32: effects.backlash.x.gap_mm = 'nan' is not a number\n"},
        BadInput{"empty", "", ":1:1: the file is empty\n"}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(CommandLine, AMissingFileIsNamed) {
  const Finished run = Caltwin("run nowhere.yaml");

  EXPECT_THAT(run.code, Eq(2));
  EXPECT_THAT(run.err, StartsWith("nowhere.yaml: "));
}

TEST(CommandLine, AFolderWithoutScenariosIsNamed) {
  fs::create_directories(Scratch() / "nothing");

  const Finished run = Caltwin("run " + (Scratch() / "nothing").string());

  EXPECT_THAT(run.code, Eq(2));
  EXPECT_THAT(run.err, HasSubstr("nothing: this folder has no scenarios in it\n"));
}

TEST(CommandLine, AHugeFileOfNoiseIsRefusedUnread) {
  const fs::path file = Scratch() / "noise.yaml";
  WriteTextFile(file, "x");
  fs::resize_file(file, 100'000'000);

  const Finished run = Caltwin("run " + file.string());
  fs::remove(file);

  EXPECT_THAT(run.code, Eq(2));
  EXPECT_THAT(
      run.err,
      AllOf(StartsWith(file.string()), HasSubstr("larger than any file of this kind")));
}

TEST(CommandLine, OfManyFaultsTwentyAreShown) {
  std::string text = "machine: gantry_router\ncalibrate: [gcode: {lines: [M114]}]\n";
  for (int i = 0; i < 25; ++i) text += fmt::format("wrong_{}: 1\n", i);

  const Finished run = Caltwin("run " + Written("many.yaml", text));

  EXPECT_THAT(run.code, Eq(2));
  EXPECT_THAT(run.err, HasSubstr("\nand 5 more\n"));
}

TEST(CommandLine, OneBadFileAmongGoodOnesRunsNothing) {
  const Finished run = Caltwin(fmt::format("run {} {}",
                                           Written("good.yaml", kPassing),
                                           Written("odd.yaml", "machine: 1\n")));

  EXPECT_THAT(run.code, Eq(2));
  EXPECT_THAT(run.out, IsEmpty());
}

TEST(CommandLine, AnUnknownOptionOrCommandIsBadInput) {
  EXPECT_THAT(Caltwin("run --fast x.yaml").code, Eq(2));
  EXPECT_THAT(Caltwin("ran x.yaml").code, Eq(2));
  EXPECT_THAT(Caltwin("").code, Eq(2));
  EXPECT_THAT(Caltwin("run x.yaml --fidelity slow").code, Eq(2));
  EXPECT_THAT(Caltwin("run x.yaml --seeds 0").code, Eq(2));
}

TEST(CommandLine, RecordOfSeveralRunsIsRefused) {
  const Finished run =
      Caltwin("run " + Written("good.yaml", kPassing) + " --seeds 2 --record a.csv");

  EXPECT_THAT(run.code, Eq(2));
  EXPECT_THAT(run.err, HasSubstr("--record keeps one run, and this is several"));
}

TEST(CommandLine, ALostProcessExitsWithThree) {
  const Finished run = Caltwin(
      "run " + Written("lost.yaml",
                       "machine: gantry_router\nfidelity: fast\n"
                       "calibrate: [external: {command: [sh, -c, 'kill -9 $$']}]\n"));

  EXPECT_THAT(run.code, Eq(3));
}

TEST(CommandLine, EveryCommandHasHelp) {
  const Finished all = Caltwin("--help");
  EXPECT_THAT(all.code, Eq(0));
  for (const Command& command : AllCommands()) {
    EXPECT_THAT(all.out, HasSubstr(std::string(command.name)));
    EXPECT_THAT(Caltwin(fmt::format("{} --help", command.name)).code, Eq(0))
        << command.name;
  }
  EXPECT_THAT(Caltwin("--version").out, StartsWith("caltwin "));
}

// Of every kind of machine: a scenario whose program does that to itself or to caltwin.
std::vector<std::string> EndedBy(const std::string& command) {
  const std::string steps =
      "calibrate:\n  - external: {command: [sh, -c, " + command + "]}\n";
  std::vector<std::string> files;
  for (const char* machine : {"gantry_router",
                              "delta_printer",
                              "triple_z_printer",
                              "z_station",
                              "motor_stage"}) {
    files.push_back(
        Written(std::string(machine) + ".yaml",
                "machine: " + std::string(machine) + "\nfidelity: fast\n" + steps));
  }
  return files;
}

TEST(CommandLine, OnEveryKindOfMachineALostProgramExitsWithThree) {
  for (const std::string& file : EndedBy("kill -9 $$")) {
    EXPECT_THAT(Caltwin("run " + file).code, Eq(3)) << file;
  }
}

TEST(CommandLine, OnEveryKindOfMachineAnInterruptExitsWith130) {
  for (const std::string& file : EndedBy("kill -INT $PPID; sleep 9")) {
    EXPECT_THAT(Caltwin("run " + file).code, Eq(130)) << file;
  }
}

TEST(Explain, ListsAndExplains) {
  EXPECT_THAT(Caltwin("explain").out,
              AllOf(HasSubstr("backlash"), HasSubstr("diverges")));
  EXPECT_THAT(Caltwin("explain backlash.x").out,
              AllOf(HasSubstr("gap_mm [mm]"), HasSubstr("effect of a motor stage")));
  EXPECT_THAT(Caltwin("explain truth_within").out, HasSubstr("(key)"));
  const Finished typo = Caltwin("explain baklash");
  EXPECT_THAT(typo.code, Eq(2));
  EXPECT_THAT(typo.err, HasSubstr("did you mean 'backlash'?"));
}

TEST(NewMachine, IsAValidFileAndNeverOverwrites) {
  const std::string here = "cd " + Scratch().string() + " && ";
  const auto in_scratch = [&](const std::string& arguments) {
    return std::system(
               fmt::format(
                   "{}{} {} >out 2>err </dev/null", here, CALTWIN_BINARY, arguments)
                   .c_str()) >>
           8;
  };

  EXPECT_THAT(in_scratch("new machine my_mill"), Eq(0));
  EXPECT_THAT(in_scratch("validate models/my_mill/machine.yaml"), Eq(0));
  EXPECT_THAT(in_scratch("new machine my_mill"), Eq(2));
  EXPECT_THAT(in_scratch("new machine ../evil"), Eq(2));
  EXPECT_THAT(in_scratch("new machine other --like nobody"), Eq(2));
}

TEST(NewMachine, ComesFromAPersonsOwnPrinterCfg) {
  const fs::path config =
      fs::absolute("tests/fuzz/corpus/printer_cfg/delta.cfg").string();
  const std::string here = "cd " + Scratch().string() + " && ";
  const auto in_scratch = [&](const std::string& arguments) {
    const std::string command =
        fmt::format("{}{} {} >out 2>err", here, CALTWIN_BINARY, arguments);
    return std::system(command.c_str()) >> 8;
  };

  EXPECT_THAT(in_scratch("new machine my_delta --from " + config.string()), Eq(0));
  EXPECT_THAT(in_scratch("validate models/my_delta/machine.yaml"), Eq(0));
  EXPECT_TRUE(fs::exists(Scratch() / "models/my_delta/printer.cfg"));
  EXPECT_THAT(in_scratch("new machine my_delta --from " + config.string()), Eq(2));
  EXPECT_THAT(in_scratch("new machine none --from /dev/null"), Eq(2));
  EXPECT_FALSE(fs::exists(Scratch() / "models/none"));
}

TEST(Calibrate, RefusesToChangeARealMachineUnasked) {
  const Finished run = Caltwin(
      "calibrate --link tcp:127.0.0.1:1 --procedure 'gcode: {lines: [M114]}' --apply");

  EXPECT_THAT(run.code, Eq(2));
  EXPECT_THAT(run.err, HasSubstr("add --yes"));
}

TEST(Calibrate, TalksToATwin) {
  const std::string truth = Written("t.yaml", "settings: {steps_per_mm: {x: 808}}\n");

  const Finished run = Caltwin(
      fmt::format("calibrate --link 'twin:gantry_router?truth={}&fidelity=fast' "
                  "--procedure 'gcode: {{lines: [M92]}}'",
                  truth));

  EXPECT_THAT(run.code, Eq(0));
  EXPECT_THAT(run.out, HasSubstr("X: 808.000"));
}

TEST(Calibrate, KnowsDeltas) {
  const std::string truth =
      Written("delta.yaml",
              "effects: {endstop.a: {error_mm: 0.3}, delta_radius: {error_mm: 0.5}}\n");
  const std::string link = fmt::format(
      "calibrate --link 'twin:delta_printer?fidelity=fast&truth={}' ", truth);

  const Finished asked = Caltwin(link + "--procedure delta_joint");
  const Finished applied = Caltwin(link + "--procedure delta_joint --apply");
  const Finished typo = Caltwin(link + "--procedure delta_jiont");

  EXPECT_THAT(asked.code, Eq(0));
  EXPECT_THAT(asked.out, HasSubstr("Nothing was applied: --apply does that."));
  EXPECT_THAT(applied.code, Eq(0));
  EXPECT_THAT(applied.out, HasSubstr("delta_radius 130 -> 130.5"));
  EXPECT_THAT(applied.out, HasSubstr(", applied"));
  EXPECT_THAT(typo.code, Eq(2));
  EXPECT_THAT(typo.err, HasSubstr("There are g33, rrf_least_squares, "));
}

TEST(Serve, SpeaksADeltasDialectAndNoOther) {
  const Finished run = Caltwin("serve --machine delta_printer --tcp 0 --dialect rrf");

  EXPECT_THAT(run.code, Eq(2));
  EXPECT_THAT(run.err, HasSubstr("it speaks marlin: leave the option away"));
}

TEST(Calibrate, ATwinThatIsMisspeltIsBadInput) {
  const Finished run =
      Caltwin("calibrate --link 'twin:gantry_router?speed=fast' --procedure next_all");

  EXPECT_THAT(run.code, Eq(2));
  EXPECT_THAT(run.err, HasSubstr("'speed=fast' is not understood"));
}

}  // namespace
}  // namespace caltwin

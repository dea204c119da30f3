#include "tools/commands/spare_files.h"

#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/text_file.h"
#include "tests/base/temp_folder.h"
#include "tests/tools/run_command.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::StrEq;

constexpr std::size_t kMostBytes = 1 << 20;

class SpareFiles : public ::testing::Test {
 protected:
  std::string File(const std::string& name) const { return (folder_ / name).string(); }
  std::string Written(const std::string& name, const std::string& text) const {
    WriteTextFile(folder_ / name, text);
    return File(name);
  }
  /// Refused, and what is read is as it was.
  static void ExpectSpared(Action (*declare)(CLI::App*),
                           const std::vector<std::string>& words,
                           const std::string& read) {
    const std::string before = ReadTextFile(read, kMostBytes);
    const Answer answer = RunCommand(declare, words);
    EXPECT_EQ(answer.exit_code, kBadInput) << words.back();
    EXPECT_THAT(answer.fault, HasSubstr("which is read: it would be written over"));
    EXPECT_EQ(ReadTextFile(read, kMostBytes), before);
    EXPECT_EQ(answer.out, "");
  }

  TempFolder folder_{};
};

TEST_F(SpareFiles, AFileIsTheSameOverLinksAndDots) {
  const std::string file = Written("a.csv", "x");
  fs::create_symlink(file, File("link.csv"));
  fs::create_hard_link(file, File("hard.csv"));
  const std::string other = Written("b.csv", "x");

  EXPECT_TRUE(IsSameFile(file, File("./a.csv")));
  EXPECT_TRUE(IsSameFile(file, File("link.csv")));
  EXPECT_TRUE(IsSameFile(file, File("hard.csv")));
  EXPECT_FALSE(IsSameFile(file, other));
}

TEST_F(SpareFiles, WhatIsNotThereYetIsComparedByName) {
  EXPECT_TRUE(IsSameFile(File("new.yaml"), File("./none/../new.yaml")));
  EXPECT_FALSE(IsSameFile(File("new.yaml"), File("newer.yaml")));
  EXPECT_FALSE(IsSameFile("/dev/null", "/dev/null"));
}

TEST_F(SpareFiles, NothingIsWrittenTwice) {
  const auto fault = [](const std::vector<NamedFile>& written) -> std::string {
    try {
      RefuseOverwriting({}, written);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(fault({{"--json", "x/o"}, {"--extend", "x/./o"}}),
              StrEq("--extend: 'x/./o' is what --json writes too\n"
                    "  give another name"));
  EXPECT_THAT(fault({{"--json", "r/index.html"}, {"--report", "r", true}}),
              HasSubstr("is what --json writes too"));
  EXPECT_THAT(fault({{"--report", Written("r", ""), true}}),
              HasSubstr("is a file, where a folder is wanted"));
  EXPECT_THAT(fault({{"--json", "-"}, {"--extend", "-"}, {"--report", ""}}), StrEq(""));
}

TEST_F(SpareFiles, DiagnoseSparesAllThatItReads) {
  const std::string source = CALTWIN_SOURCE_DIR;
  const std::string data = Written(
      "d.csv",
      ReadTextFile(source + "/tests/data/iso230/ess_target_x_2022-04.csv", kMostBytes));
  const std::string header = Written("d.yaml", "format: 1\n");
  const std::string before = Written("before.csv", ReadTextFile(data, kMostBytes));
  const std::string base =
      Written("m.yaml",
              ReadTextFile(source + "/models/gantry_router/machine.yaml", kMostBytes));
  fs::copy(source + "/models/gantry_router/model.xml", File("model.xml"));
  const std::string machine = Written("ext.yaml", "extends: m.yaml\n");
  fs::create_symlink(data, File("link"));

  for (const char* option : {"--json", "--extend", "--correction", "--report"}) {
    for (const std::string& read : {data, header, before, base, machine}) {
      std::vector<std::string> words = {
          data, "--machine", machine, "--before", before, "--for", "rrf"};
      words.insert(words.end(), {option, read});
      ExpectSpared(DeclareDiagnose, words, read);
    }
    ExpectSpared(DeclareDiagnose, {data, "--for", "rrf", option, File("link")}, data);
  }
}

TEST_F(SpareFiles, OtherCommandsSpareWhatTheyRead) {
  const std::string plan =
      Written("plan.yaml",
              "machine: gantry_router\ninstruments: {laser: {sigma_um: 0.5}}\n"
              "campaigns:\n  - iso230: {axis: x, positions: 3, runs: 1}\n");
  const std::string truth = Written("truth.yaml", "effects: {}\n");
  const std::string rows = Written("rows.csv", "row\n");
  const std::string scenario = Written("s.yaml",
                                       "about: x\nmachine: gantry_router\n"
                                       "calibrate: [gcode: {lines: [G28]}]\n");

  ExpectSpared(DeclarePlan, {plan, "--json", plan}, plan);
  ExpectSpared(
      DeclareSimulate, {plan, "--truth", truth, "--out", File("truth.csv")}, truth);
  ExpectSpared(DeclareIso230, {rows, "--json", rows}, rows);
  ExpectSpared(DeclareRun, {scenario, "--json", scenario}, scenario);
  ExpectSpared(DeclareRun, {scenario, "--record", File("s.csv")}, scenario);
  ExpectSpared(DeclareCalibrate,
               {"--link",
                "twin:gantry_router?truth=" + truth,
                "--procedure",
                "next_dual_dimension",
                "--axis",
                "x",
                "--record",
                truth},
               truth);
}

}  // namespace
}  // namespace caltwin

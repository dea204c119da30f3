#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "sim/base/rng.h"
#include "tests/firmware/bench.h"

namespace caltwin {
namespace {

TEST(FirmwareSession, AnswersAsTheTranscriptSays) {
  std::ifstream file("tests/firmware/session.transcript");
  ASSERT_TRUE(file.good());
  FirmwareBench bench;
  std::vector<std::string> pending;
  std::string sent = "(start)";
  int number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    if (line.starts_with("> ")) {
      EXPECT_TRUE(pending.empty()) << number << ": also printed: " << pending.front();
      sent = line.substr(2);
      pending = bench.firmware.Execute(sent).lines;
    } else if (line.starts_with("< ")) {
      ASSERT_FALSE(pending.empty()) << number << ": nothing was printed for " << sent;
      EXPECT_EQ(pending.front(), line.substr(2)) << "line " << number;
      pending.erase(pending.begin());
    }
  }
  EXPECT_GT(number, 50);
}

TEST(FirmwareSession, NoiseNeverBreaksIt) {
  const std::vector<std::string> pieces = {
      "G28",    "G0 X",          "G1 Y", "G38.2 X", "M92 X", "M425 Z", "G92 X",
      "echo ",  "if ",           "1",    "-3.5",    "{",     "}",      "(",
      "global", " a = ",         "\"",   "F60",     " ",     "M98 P",  "G10 L2 P1 X",
      "300",    "set global.a[", "]",    "*",       "G54",   "G91",    "else",
      "M999",   "while "};
  Rng rng(1, 0, "noise");
  FirmwareBench bench;
  for (int i = 0; i < 1'000; ++i) {
    std::string line;
    const auto count = 1 + static_cast<int>(rng.Uniform() * 5);
    for (int k = 0; k < count; ++k) {
      line += pieces[static_cast<std::size_t>(rng.Uniform() *
                                              static_cast<double>(pieces.size()))];
    }
    bench.firmware.Execute(line);
  }
  // Whatever it was told, it still stands on whole steps and can be restarted.
  bench.Say({"M999"});
  EXPECT_TRUE(bench.Say({"G28", "G0 X10 Y10", "M400"}).empty());
  EXPECT_EQ(bench.firmware.motor_steps(), bench.plant.steps);
}

}  // namespace
}  // namespace caltwin

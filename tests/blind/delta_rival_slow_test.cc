// A cause whose size the rows do not tell gives its place to a rival that they do
// measure. Rows that lead there are rare: one case in some 300 with two causes.

#include <filesystem>
#include <set>
#include <string>
#include <utility>

#include <gtest/gtest.h>
#include <unistd.h>

#include "tests/blind/delta/case.h"
#include "tests/blind/diagnosis.h"

namespace blind {
namespace {

namespace fs = std::filesystem;

TEST(DeltaRival, TakesThePlaceOfACauseWhoseSizeIsUnknown) {
  const fs::path folder =
      fs::temp_directory_path() / ("blind_rival_" + std::to_string(getpid()));
  // Play of tower A's carriage and a frame that grows while it warms up.
  const DeltaCase made = MakeDeltaCase(
      {.kind = "pair", .cause = "carriage_backlash", .sigma = 4.9, .seed = 552806226});
  WriteDeltaCase(made, folder.string());

  const nlohmann::json answer =
      Diagnose({.binary = CALTWIN_BINARY, .folder = folder.string()}, folder.string());
  fs::remove_all(folder);

  ASSERT_TRUE(answer.is_object());
  std::set<std::pair<std::string, std::string>> named;
  for (const auto& finding : answer.at("findings")) {
    named.emplace(finding.at("cause"), finding.at("axis"));
  }
  const std::set<std::pair<std::string, std::string>> hidden{
      {"carriage_backlash", "a"}, {"frame_temperature", "frame"}};
  EXPECT_EQ(named, hidden) << answer.at("findings").dump(1);
}

}  // namespace
}  // namespace blind

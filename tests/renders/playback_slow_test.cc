#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "renders/playback.h"

namespace caltwin {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StrEq;

Scenario Named(const std::string& name) {
  return ReadScenario(std::filesystem::path(CALTWIN_SOURCE_DIR) / "scenarios" /
                      (name + ".yaml"));
}

RunResult Sent(const std::string& transcript) {
  return {.transcript = transcript};
}

TEST(Playback, HoldsTheMachineAsBuiltAndWhatIsOtherWithItsErrorsEnlarged) {
  const auto json = PlaybackJson(Named("first_light"), 1, 2, "> G28\n< ok\n");

  ASSERT_TRUE(json);
  const auto& scenes = (*json)["scenes"];
  ASSERT_EQ(scenes.size(), 2);
  EXPECT_EQ(scenes[0]["exaggerate"], 1);
  EXPECT_EQ(scenes[1]["exaggerate"], 30);
  EXPECT_TRUE(scenes[0]["scene"].contains("geoms"));
  EXPECT_FALSE(scenes[1]["scene"].contains("bodies"));
  EXPECT_NE(scenes[0]["grid"]["poses"], scenes[1]["grid"]["poses"]);
  EXPECT_TRUE(scenes[0]["reach_mm"].is_null());
  EXPECT_EQ((*json)["lines"], 2);
}

// Its rods do not reach with errors thirty times as large.
TEST(Playback, OfADeltaGoesInShortWays) {
  const auto json = PlaybackJson(Named("delta_joint_recovers"), 1, 0, "> G28\n");

  ASSERT_TRUE(json);
  EXPECT_EQ((*json)["scenes"][0]["reach_mm"], 15);
}

TEST(Playback, IsNoneWhereThereIsNoTipToFollow) {
  EXPECT_FALSE(PlaybackJson(Named("motor_stepper_home"), 1, 0, "> G28\n"));
  EXPECT_FALSE(PlaybackJson(Named("z_offset_over_temperature"), 1, 0, "> G28\n"));
  EXPECT_THAT(PlaybackHtml(Named("motor_stepper_home"), Sent("> G28\n"), "x"),
              StrEq(""));
  EXPECT_THAT(PlaybackHtml(Named("first_light"), Sent(""), "x"), StrEq(""));
}

TEST(Playback, IsAboutWhatToBuildWhereThereIsNoPlayer) {
  EXPECT_THAT(PlaybackHtml(Named("first_light"), Sent("> G28\n"), ""),
              StrEq("<p>Built pages add a playback of this run here: "
                    "<code>tools/pages.sh</code> builds them.</p>\n"));
}

TEST(Playback, KeepsWhatAMachineAnswersInItsScriptElement) {
  const std::string html = PlaybackHtml(
      Named("first_light"), Sent("> G28\n< </script><img src=x>\n"), "</script>");

  EXPECT_THAT(html, AllOf(HasSubstr("id=\"playback-player\""), Not(HasSubstr("<img"))));
  EXPECT_THAT(html, HasSubstr(">PC9zY3JpcHQ+<"));
}

TEST(Playback, OfALongRunIsOfItsFirstLines) {
  std::string transcript;
  while (transcript.size() < 3'000'000) transcript += "> G1 X1\n";

  const auto json = PlaybackJson(Named("first_light"), 1, 0, transcript);

  EXPECT_EQ((*json)["lines"], transcript.size() / 8);
  const auto kept = (*json)["transcript"].get<std::string>();
  EXPECT_LT(kept.size(), 500'000);
  EXPECT_TRUE(kept.ends_with("> G1 X1\n"));
}

TEST(Playback, CutsATextBehindAWholeLine) {
  EXPECT_EQ(WholeLinesOf("ab\ncd\n", 6), "ab\ncd\n");
  EXPECT_EQ(WholeLinesOf("ab\ncd\n", 5), "ab\n");
  EXPECT_EQ(WholeLinesOf("ab\ncd\n", 2), "");
}

}  // namespace
}  // namespace caltwin

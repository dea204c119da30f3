#include <algorithm>
#include <filesystem>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <zlib.h>

#include "renders/html.h"
#include "renders/playback.h"
#include "sim/base/rng.h"

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

/// The inverse of Base64.
std::string PlainOf(std::string_view base64) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string plain;
  unsigned bits = 0;
  int num_bits = 0;
  for (const char digit : base64.substr(0, base64.find('='))) {
    bits = bits << 6 | static_cast<unsigned>(kDigits.find(digit));
    num_bits += 6;
    if (num_bits < 8) continue;
    num_bits -= 8;
    plain += static_cast<char>(bits >> num_bits & 0xff);
  }
  return plain;
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

/// What a page's playback is made of, unpacked again.
nlohmann::json DataIn(const std::string& html) {
  const std::string_view begin = "id=\"playback-data\">";
  const std::size_t from = html.find(begin) + begin.size();
  const std::string packed = PlainOf(html.substr(from, html.find('<', from) - from));
  std::string text(50'000'000, '\0');
  uLongf size = text.size();
  uncompress(reinterpret_cast<Bytef*>(text.data()),
             &size,
             reinterpret_cast<const Bytef*>(packed.data()),
             packed.size());
  text.resize(size);
  return nlohmann::json::parse(text);
}

TEST(Playback, StandsPackedInItsPage) {
  const std::string transcript = "> G28\n< </script><img src=x>\xff\n";

  const std::string html =
      PlaybackHtml(Named("first_light"), Sent(transcript), "</script>");

  EXPECT_THAT(html, AllOf(HasSubstr("id=\"playback-player\""), Not(HasSubstr("<img"))));
  EXPECT_THAT(html, HasSubstr(">" + Base64("</script>") + "<"));
  EXPECT_EQ(DataIn(html)["transcript"], "> G28\n< </script><img src=x>\uFFFD\n");
}

TEST(Playback, OfALongRunIsOfItsFirstLines) {
  Rng rng(1, 0, "a long run");
  std::string transcript;
  while (transcript.size() < 3'000'000) {
    transcript += fmt::format("> G1 X{:.9f} Y{:.9f}\n", rng.Normal(), rng.Normal());
  }

  const std::string html = PlaybackHtml(Named("first_light"), Sent(transcript), "x");

  EXPECT_LT(html.size(), 410'000);
  const nlohmann::json data = DataIn(html);
  const auto kept = data["transcript"].get<std::string>();
  EXPECT_GT(kept.size(), 300'000);
  EXPECT_LT(kept.size(), transcript.size());
  EXPECT_TRUE(transcript.starts_with(kept) && kept.ends_with("\n"));
  EXPECT_EQ(data["lines"], std::ranges::count(transcript, '\n'));
}

TEST(Playback, CutsATextBehindAWholeLine) {
  EXPECT_EQ(WholeLinesOf("ab\ncd\n", 6), "ab\ncd\n");
  EXPECT_EQ(WholeLinesOf("ab\ncd\n", 5), "ab\n");
  EXPECT_EQ(WholeLinesOf("ab\ncd\n", 2), "");
}

}  // namespace
}  // namespace caltwin

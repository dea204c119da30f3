#include "renders/playback.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "renders/html.h"
#include "renders/kinds/as_built.h"
#include "renders/kinds/still.h"
#include "renders/pose_grid.h"
#include "renders/scene_json.h"
#include "sim/base/deflate.h"
#include "sim/base/text_file.h"

namespace caltwin {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kTolerance_mm = 0.5;  // Below a pixel of a machine a metre high.
constexpr double kReach_mm = 15;       // Of what goes in arcs.
// A report stays below two million bytes.
constexpr std::size_t kMostPacked_bytes = 300'000;

// Unpacks what the run is played from and the player, and begins it. An element that a
// script makes may hold one, as the page's policy has it.
constexpr std::string_view kBegin = R"(
(async function () {
  'use strict';
  async function unpack(id, format) {
    var element = document.getElementById(id);
    var packed = Uint8Array.from(atob(element.textContent), function (c) { return c.charCodeAt(0); });
    var plain = new Blob([packed]).stream().pipeThrough(new DecompressionStream(format));
    return new Response(plain).text();
  }
  var data = await unpack('playback-data', 'deflate');
  var script = document.createElement('script');
  script.textContent = await unpack('playback-script', 'gzip');
  document.getElementById('playback-data').textContent = data;
  document.body.appendChild(script);
})();
)";

Json SceneOf(const Enlarged& drawn) {
  const PoseGrid grid = GridOfPoses(drawn.still, kTolerance_mm);
  return {{"exaggerate", drawn.exaggerate},
          {"scene", SceneJson(drawn.still)},
          {"grid", ToJson(grid)},
          {"reach_mm", grid.IsStraight() ? Json() : Json(kReach_mm)}};
}

void DropWhatIsAlike(const Json& like, Json* scene) {
  for (const auto& [key, value] : like.items()) {
    if ((*scene)[key] == value) scene->erase(key);
  }
}

/// The machine as built and, where that is another, enlarged.
Json ScenesOf(const Scenario& scenario, std::uint64_t seed, const Enlarged& built) {
  Json scenes = Json::array({SceneOf(built)});
  const Enlarged larger = EnlargedStillOf(scenario, seed, kExaggerate);
  Json enlarged = SceneOf(larger);
  const bool is_other =
      enlarged["scene"] != scenes[0]["scene"] || enlarged["grid"] != scenes[0]["grid"];
  if (larger.exaggerate <= 1 || !is_other) return scenes;
  DropWhatIsAlike(scenes[0]["scene"], &enlarged["scene"]);
  scenes.push_back(std::move(enlarged));
  return scenes;
}

/// What is played, packed; of a run too long for a report its first lines.
std::string PackedFor(Json playback, std::string_view transcript) {
  for (std::size_t most = transcript.size();; most /= 2) {
    playback["transcript"] = WholeLinesOf(transcript, most);
    std::string packed =
        Deflated(playback.dump(-1, ' ', false, Json::error_handler_t::replace));
    if (packed.size() <= kMostPacked_bytes || most == 0) return packed;
  }
}

}  // namespace

std::string_view WholeLinesOf(std::string_view text, std::size_t most_bytes) {
  if (text.size() <= most_bytes) return text;
  const std::size_t end = text.substr(0, most_bytes).rfind('\n');
  return text.substr(0, end == std::string_view::npos ? 0 : end + 1);
}

std::optional<Json> PlaybackJson(const Scenario& scenario,
                                 std::uint64_t seed,
                                 int touches,
                                 std::string_view transcript) {
  Still built = StillOf(scenario, seed, /*exaggerate=*/1);
  if (!built.move_to) return std::nullopt;
  return Json{{"scenes", ScenesOf(scenario, seed, {std::move(built)})},
              {"touches", touches},
              {"transcript", transcript},
              {"lines", std::ranges::count(transcript, '\n')}};
}

std::string PackedPlayer() {
  const std::filesystem::path file = ShareFolder() / "web" / "player.js.gz";
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) return "";
  return ReadTextFile(file, kLargestFile_bytes);
}

std::string PlaybackHtml(const Scenario& scenario,
                         const RunResult& result,
                         const std::string& packed_player) {
  if (result.transcript.empty()) return "";
  const auto json =
      PlaybackJson(scenario, result.seed, result.touches, result.transcript);
  if (!json) return "";
  if (packed_player.empty()) {
    return "<p>Built pages add a playback of this run here: "
           "<code>tools/pages.sh</code> builds them.</p>\n";
  }
  return fmt::format(
      "<div id=\"playback-player\"><p>On a screen, in a browser with JavaScript, the "
      "run is "
      "played back here.</p></div>\n"
      "<script type=\"text/plain\" id=\"playback-data\">{}</script>\n"
      "<script type=\"text/plain\" id=\"playback-script\">{}</script>\n"
      "<script>{}</script>\n",
      Base64(PackedFor(*json, result.transcript)),
      Base64(packed_player),
      kBegin);
}

}  // namespace caltwin

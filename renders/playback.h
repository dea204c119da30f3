#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

#include "scenarios/result.h"
#include "scenarios/scenario.h"

namespace caltwin {

/// What a run is played back from without the program:
///
///   scenes      the machine as built and, where that is another, its errors enlarged;
///               of each:
///     exaggerate  how many times they are enlarged
///     scene       SceneJson; of the second what is not as of the first
///     grid        ToJson of a PoseGrid
///     reach_mm    the longest way of the tip along which its parts go straight; null:
///                 any
///   touches     how often the run touched
///   transcript  what was sent and answered
///   lines       how many lines that are
///
/// nullopt: the machine has no tip to follow.
std::optional<nlohmann::ordered_json> PlaybackJson(const Scenario& scenario,
                                                   std::uint64_t seed,
                                                   int touches,
                                                   std::string_view transcript);

/// The whole lines that a text begins with, `most_bytes` at most.
std::string_view WholeLinesOf(std::string_view text, std::size_t most_bytes);

/// The script that plays it, as tools/pages.sh builds it (web/player.js.gz), packed by
/// gzip. Empty: it was not built.
std::string PackedPlayer();

/// A run's playback for its report: where it is shown, what it is made of and what
/// plays it, a part of a page. Empty: nothing can be played. Where the script was not
/// built, a line that says how to.
std::string PlaybackHtml(const Scenario& scenario,
                         const RunResult& result,
                         const std::string& packed_player);

}  // namespace caltwin

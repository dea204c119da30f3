#include <algorithm>
#include <array>
#include <string_view>

#include "calibration/estimate/observability.h"

namespace caltwin {
namespace {

// A blind group that holds all of `causes` (an empty second: the first alone) is told
// apart by `advice`.
struct Remedy {
  std::array<std::string_view, 2> causes;
  std::string_view advice;
};

constexpr Remedy kRemedies[] = {
    {{"probe_pretravel", "backlash"},
     "Touch and release the same face at two feeds (G38.2, then G38.4), or read one "
     "position approached from both sides with a dial or a laser: that tells the "
     "backlash alone."},
    {{"probe_pretravel", "tip_size"},
     "Measure the ball with a calliper: that tells the tip's radius; no span and no "
     "bore does."},
    {{"backlash", "tip_size"},
     "Measure the ball with a calliper, and read one position from both sides with a "
     "dial or a laser."},
    {{"probe_pretravel", "placement"},
     "Touch a second face that looks the other way: for z the underside of a ledge of "
     "known thickness, with the disc stylus."},
    {{"backlash", "placement"}, "Approach the same position in the other sense too."},
    {{"tip_size", "placement"},
     "Touch a second face that looks the other way, and measure the ball."},
    {{"probe_hysteresis", "backlash"},
     "Read one position from both sides with a dial or a laser, or take the switch's "
     "hysteresis from the probe's data sheet."},
    {{"trigger_latency", "probe_pretravel"},
     "Touch at two or three feeds: only the latency grows with the feed."},
    {{"trigger_latency", "backlash"},
     "Touch and release at two feeds and extrapolate to rest."},
    {{"windup_load", "backlash"}, "Repeat the reversal under a second axial load."},
    {{"steps_per_mm", "block_size"}, "Measure a second artefact of another size."},
    {{"steps_per_mm", "placement"},
     "Measure two sizes along the axis, or one size and its place twice."},
    {{"squareness", "bed_tilt"},
     "Touch a side face at two heights, and the table at three places."},
    {{"bed_tilt", "placement"},
     "Touch the table at three places that do not lie on one line."},
    {{"steps_per_mm", ""}, "Measure two certified sizes along that axis."},
    {{"backlash", ""},
     "Move the axis in both senses to one position and read it, or touch and release."},
    {{"probe_pretravel", ""}, "Touch along that axis."},
    {{"squareness", ""}, "Touch one side face at two positions along the other axis."},
    {{"bed_tilt", ""}, "Touch the table at three places that do not lie on one line."},
    {{"windup_load", ""}, "Repeat the reversal under two axial loads."},
    {{"trigger_latency", ""}, "Touch one face at two feeds."},
    {{"tip_size", ""}, "Measure the ball with a calliper."},
};

bool Has(std::span<const std::string> names, std::string_view cause) {
  return std::ranges::any_of(names, [&](const std::string& name) {
    return name.substr(0, name.find('.')) == cause;
  });
}

}  // namespace

std::vector<std::string> AdviceFor(std::span<const std::string> names) {
  std::vector<std::string> advice;
  const bool alone = names.size() == 1;
  for (const Remedy& remedy : kRemedies) {
    if (remedy.causes[1].empty() != alone) continue;
    if (!Has(names, remedy.causes[0])) continue;
    if (!alone && !Has(names, remedy.causes[1])) continue;
    advice.emplace_back(remedy.advice);
  }
  return advice;
}

}  // namespace caltwin

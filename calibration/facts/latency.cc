#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "calibration/facts/cells.h"
#include "calibration/facts/motion.h"
#include "sim/base/units.h"
#include "sim/base/with_sd.h"

namespace caltwin {
namespace {

constexpr double kSure = 4;
}  // namespace

// Touches of one face at several feeds: value = a - latency v, so long as nothing else
// differs.
void FactsOfLatency(const std::vector<const Row*>& rows,
                    const Repeats& repeats,
                    Facts* facts) {
  constexpr std::size_t kFewestFeeds = 3;
  for (const auto& [key, cell] : CellsOf(rows, kAnyFeed | kAnyHome)) {
    std::map<double, std::pair<double, double>> feeds;
    for (const Row* row : cell) {
      if (!Known(row->feed_mm_s) || row->kind != RowKind::kTouch) continue;
      feeds[row->feed_mm_s].first += row->value_mm;
      feeds[row->feed_mm_s].second += 1;
    }
    if (feeds.size() < kFewestFeeds) continue;
    double w = 0, wv = 0, wz = 0, wvv = 0, wvz = 0;
    for (const auto& [feed, sum] : feeds) {
      w += sum.second;
      wv += sum.second * feed;
      wz += sum.first;
      wvv += sum.second * feed * feed;
      wvz += feed * sum.first;
    }
    const double spread = wvv - wv * wv / w;
    const double slope_s = (wvz - wv * wz / w) / spread;
    double left_mm2 = 0;
    for (const auto& [feed, sum] : feeds) {
      const double fit_mm = wz / w + slope_s * (feed - wv / w);
      left_mm2 += sum.second * std::pow(sum.first / sum.second - fit_mm, 2);
    }
    const double dof = static_cast<double>(feeds.size()) - 2;
    double noise_mm = std::sqrt(left_mm2 / dof);
    const double reading_mm = repeats.NoiseOf(*cell.front()).sd_mm;
    if (Known(reading_mm)) noise_mm = std::max(noise_mm, reading_mm);
    const double sd_s = noise_mm / std::sqrt(spread);
    if (std::abs(slope_s) < kSure * sd_s) continue;
    facts->all.push_back(
        {.id = "latency",
         .axis = AxisAlong(*cell.front()) < 0
                     ? ""
                     : kAxisNames[static_cast<std::size_t>(AxisAlong(*cell.front()))],
         .figures = {{"latency_ms", -1e3 * slope_s, 1e3 * sd_s}},
         .sigmas = std::abs(slope_s) / sd_s,
         .cause = slope_s < 0 ? "trigger_latency" : "",
         .parameters = {{"latency_ms", -1e3 * slope_s, 1e3 * sd_s}},
         .sentence = fmt::format(
             "The trigger comes {} {}: the faster the probe, the further it has gone "
             "({} feeds, a straight line). Probe at one feed always, or slower: the "
             "rest "
             "is constant and calibrates away",
             WithSd(std::abs(1e3 * slope_s), 1e3 * sd_s, "ms"),
             slope_s < 0 ? "late" : "early",
             feeds.size()),
         .is_answer = true});
    return;
  }
}

}  // namespace caltwin

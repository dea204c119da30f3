#include "sim/measure/import/pulse_rate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/units.h"
#include "sim/measure/import/fields.h"

namespace caltwin {
namespace {

// Guaranteed by grbl's own documentation on a 16 MHz AVR.
constexpr double kGrblMost_hz = 30e3;

// Numbers before "mm/min", "mm/m".
std::vector<double> FeedsIn(const std::string& lower) {
  constexpr std::array<std::string_view, 3> kUnits = {"mm/min", "mm/m", "mmpm"};
  std::vector<double> feeds;
  for (std::size_t at = lower.find("mm"); at != std::string::npos;
       at = lower.find("mm", at + 1)) {
    const std::string_view unit = std::string_view(lower).substr(at);
    const bool is_unit = std::ranges::any_of(kUnits, [&](std::string_view name) {
      const bool ends = unit.size() == name.size() ||
                        (unit.size() > name.size() &&
                         (unit[name.size()] < 'a' || unit[name.size()] > 'z'));
      return unit.starts_with(name) && ends;
    });
    if (!is_unit) continue;
    const auto feed = NumberBefore(lower, at);
    if (feed && *feed > 0) feeds.push_back(*feed);
  }
  return feeds;
}

}  // namespace

void PulseRate::Take(const ConsoleLine& line) {
  is_grbl_ |= line.lower.find("grbl") != std::string::npos;
  constexpr std::array<std::string_view, 13> kFast = {"grblhal",
                                                      "grbl 1.2",
                                                      "grbl 1.3",
                                                      "esp32",
                                                      "teensy",
                                                      "stm32",
                                                      "fluidnc",
                                                      "lpc",
                                                      "dlc32",
                                                      "smoothie",
                                                      "samd",
                                                      "rp2040",
                                                      "g2core"};
  is_fast_board_ |= std::ranges::any_of(kFast, [&](std::string_view word) {
    return line.lower.find(word) != std::string::npos;
  });
  for (std::size_t k = 0; k < 3; ++k) {
    const int axis = static_cast<int>(k);
    const auto steps = GrblSetting(line, 100 + axis);
    if (steps && SettingsInForce::kSteps_per_mm.Contains(*steps))
      steps_per_mm_[k] = *steps;
    const auto most = GrblSetting(line, 110 + axis);
    if (most && *most > 0) most_mm_min_[k] = *most;
  }
  for (const double feed : FeedsIn(line.lower)) feeds_mm_min_.insert(feed);
}

void PulseRate::Tell(Imported* imported) const {
  if (!is_grbl_ || is_fast_board_) return;
  std::size_t axis = 3;
  double most_hz = kGrblMost_hz;
  std::set<double> asked_mm_min;
  for (std::size_t k = 0; k < 3; ++k) {
    std::set<double> feeds = k < 2 ? feeds_mm_min_ : std::set<double>();
    if (Known(most_mm_min_[k])) feeds.insert(most_mm_min_[k]);
    if (feeds.empty() || !Known(steps_per_mm_[k])) continue;
    const double hz = steps_per_mm_[k] * *feeds.rbegin() / SFromMin(1.0);
    if (hz <= most_hz) continue;
    most_hz = hz;
    axis = k;
    asked_mm_min = feeds;
  }
  if (axis == 3) return;
  const double steps = steps_per_mm_[axis];
  std::vector<std::string> rates;
  for (const double feed : asked_mm_min) {
    const double hz = steps * feed / SFromMin(1.0);
    if (hz > kGrblMost_hz / 2)
      rates.push_back(fmt::format("{:g} mm/min is {:.0f} thousand", feed, hz / 1e3));
  }
  double fewer = steps;
  while (fewer * *asked_mm_min.rbegin() / SFromMin(1.0) > kGrblMost_hz) fewer /= 2;
  // The fastest that is allowed need not be what was asked for.
  const bool is_asked = axis < 2 && !feeds_mm_min_.empty() &&
                        steps * *feeds_mm_min_.rbegin() / SFromMin(1.0) > kGrblMost_hz;
  imported->notes.push_back(
      {.kind = is_asked ? FileNote::Kind::kElsewhere : FileNote::Kind::kOpen,
       .what = is_asked ? "settings" : "pulse_rate",
       .sentence = fmt::format(
           "{} {} for more pulses than its controller sends: at {:g} steps/mm {} "
           "pulses "
           "a second, and grbl on an 8 bit board gives about 30 thousand, which is "
           "{:.0f} mm/min here. Beyond that it loses steps, answers garbled or stops, "
           "and belt and motor are not at fault. Set fewer "
           "micro-steps (with {:g} steps/mm the same feed is {:.0f} thousand), or take "
           "a faster controller",
           "XYZ"[axis],
           is_asked ? "is asked" : "may be asked, if its board is one of 8 bit,",
           steps,
           fmt::join(rates, ", "),
           kGrblMost_hz * SFromMin(1.0) / steps,
           fewer,
           fewer * *asked_mm_min.rbegin() / SFromMin(1.0) / 1e3),
       .fact = "settings",
       .axis = std::string(1, "xyz"[axis]),
       .word = "pulse_rate",
       .figures = {{"asked_khz", most_hz / 1e3}, {"most_khz", kGrblMost_hz / 1e3}}});
}

}  // namespace caltwin

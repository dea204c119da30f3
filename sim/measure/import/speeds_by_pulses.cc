#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/measure/import/fields.h"
#include "sim/measure/import/told_stories.h"

namespace caltwin {
namespace {

/// Pulses that a driver needs for a turn, and the speed under it.
struct Speed {
  double pulses = kUnknown, rpm = 0;
};

/// What of the text is of use.
struct Seen {
  std::vector<Speed> speeds{};
  double written_pulses = kUnknown;  ///< In the controller's settings.
  double spindle_rpm = kUnknown;
  double screw_tpi = kUnknown, box_tpi = kUnknown;
  bool is_same = false;  ///< The thread that is set is the screw's.
  std::vector<double> gears{};
};

std::optional<std::size_t> FirstWord(const std::string& lower,
                                     std::initializer_list<const char*> words) {
  for (const char* word : words) {
    const std::size_t at = lower.find(word);
    if (at != std::string::npos) return at;
  }
  return std::nullopt;
}

// "800 pulses/rev    148", "as delivered    297".
std::optional<Speed> SpeedIn(const TextLine& line, const std::string& lower) {
  if (line.words.size() < 2 || lower.starts_with("#")) return std::nullopt;
  const auto rpm = NumberOf(line.words.back().text);
  if (!rpm || *rpm <= 0) return std::nullopt;
  const auto at =
      FirstWord(lower, {"pulses/rev", "pulses a turn", "pulses per rev", "steps/rev"});
  if (at) {
    const auto pulses = NumberBefore(lower, *at);
    return pulses ? std::optional(Speed{*pulses, *rpm}) : std::nullopt;
  }
  const bool is_unset =
      FirstWord(lower, {"delivered", "default", "factory"}).has_value();
  return is_unset ? std::optional(Speed{kUnknown, *rpm}) : std::nullopt;
}

void TakeSetting(const TextLine& line, const std::string& lower, Seen* seen) {
  const auto value =
      line.words.size() > 2 ? NumberOf(line.words[2].text) : std::nullopt;
  if (!value || !lower.starts_with("#define")) return;
  const std::string key = Lowered(line.words[1].text);
  if (key.find("resolution") != std::string::npos ||
      key.find("pulses") != std::string::npos) {
    seen->written_pulses = *value;
  }
  if (key.find("tpi") != std::string::npos) seen->screw_tpi = *value;
}

Seen Look(const std::string& text) {
  Seen seen;
  for (const TextLine& line : LinesOf(text)) {
    const std::string lower = Lowered(line.text);
    TakeSetting(line, lower, &seen);
    if (const auto speed = SpeedIn(line, lower)) seen.speeds.push_back(*speed);
    if (const auto rpm = NumberAfter(lower, "spindle at ")) seen.spindle_rpm = *rpm;
    const std::size_t box = lower.find("set to ");
    const bool is_tpi = box != std::string::npos && lower.find("tpi", box) != box;
    if (const auto tpi = NumberAfter(lower, "set to "); tpi && is_tpi)
      seen.box_tpi = *tpi;
    seen.is_same |= lower.find("same as the screw") != std::string::npos;
    const std::size_t colon = lower.find(":1");
    if (colon != std::string::npos) {
      if (const auto gear = NumberBefore(lower, colon)) seen.gears.push_back(*gear);
    }
  }
  return seen;
}

// What a screw should turn, of the spindle's speed.
double WantedSpeed(const Seen& seen) {
  if (seen.is_same) return seen.spindle_rpm;
  return seen.spindle_rpm * seen.screw_tpi / seen.box_tpi;
}

/// Pulses a minute, speed by speed.
std::vector<double> PulsesAMinute(const Seen& seen) {
  std::vector<double> products;
  for (const Speed& speed : seen.speeds) {
    if (Known(speed.pulses)) products.push_back(speed.pulses * speed.rpm);
  }
  return products;
}

std::string SentenceOf(const Seen& seen, double pulses_a_minute, double factor) {
  constexpr double kAlike = 0.05;
  std::string sentence = fmt::format(
      "Speed times pulses a turn is {:.0f} at every setting of the driver: it follows "
      "its pulses, and nothing slips. At the {:g} pulses a turn that are written the "
      "screw turns {:.0f} a minute where it should turn {:.0f}: a factor of {:.3g} is "
      "missing between what is written and what drives. ",
      pulses_a_minute,
      seen.written_pulses,
      pulses_a_minute / seen.written_pulses,
      WantedSpeed(seen),
      1 / factor);
  for (const Speed& speed : seen.speeds) {
    if (Known(speed.pulses)) continue;
    sentence += fmt::format("As delivered it takes {:.0f} pulses a turn. ",
                            pulses_a_minute / speed.rpm);
  }
  for (const double gear : seen.gears) {
    if (std::abs(gear * factor - 1) > kAlike) continue;
    sentence += fmt::format(
        "It is as much as the {:g}:1 of the drive: see whether that is counted. ",
        gear);
    break;
  }
  return sentence +
         "Set the driver to the pulses that are written, bring the missing factor into "
         "the settings, and measure the screw's speed again; the screw is not in "
         "question";
}

}  // namespace

std::optional<Imported> SpeedsByPulsesIn(const std::string& text) {
  constexpr double kAlike = 0.03, kRight = 0.02;
  const Seen seen = Look(text);
  const std::vector<double> products = PulsesAMinute(seen);
  const double wanted_rpm = WantedSpeed(seen);
  const bool is_told = std::isfinite(wanted_rpm) && wanted_rpm > 0 &&
                       std::isfinite(seen.written_pulses) && seen.written_pulses > 0;
  if (products.size() < 2 || !is_told) return std::nullopt;
  const auto [least, most] = std::ranges::minmax(products);
  if (most > (1 + kAlike) * least) return std::nullopt;
  double mean = 0;
  for (const double product : products)
    mean += product / static_cast<double>(products.size());
  const double factor = mean / seen.written_pulses / wanted_rpm;
  if (std::abs(factor - 1) < kRight) return std::nullopt;
  Imported imported{
      .recognised = {fmt::format("speeds of a screw under {} settings of its driver",
                                 seen.speeds.size())}};
  imported.notes.push_back({.kind = FileNote::Kind::kElsewhere,
                            .what = "settings",
                            .sentence = SentenceOf(seen, mean, factor),
                            .fact = "known_ratio",
                            .word = "pulses",
                            .figures = {{"factor", factor}}});
  return imported;
}

}  // namespace caltwin

#include "calibration/loop/probe_reading.h"

#include <charconv>
#include <string_view>

namespace caltwin {

ProbeReading ProbeReadingOf(std::span<const std::string> answer) {
  constexpr std::string_view kKey = "\"result\":";
  constexpr int kThreshold = 500;  // M558 P8 says 0 or 1000.
  for (const std::string& line : answer) {
    const std::size_t at = line.find(kKey);
    if (at == std::string::npos) continue;
    const std::string_view value = std::string_view(line).substr(at + kKey.size());
    if (value.starts_with("null")) return ProbeReading::kMissing;
    int number = 0;
    const auto read =
        std::from_chars(value.data(), value.data() + value.size(), number);
    if (read.ec != std::errc()) continue;
    return number >= kThreshold ? ProbeReading::kTriggered : ProbeReading::kFree;
  }
  return ProbeReading::kUnknown;
}

}  // namespace caltwin

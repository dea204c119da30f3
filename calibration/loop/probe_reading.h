#pragma once

#include <span>
#include <string>

namespace caltwin {

/// What the controller says of its probe between moves.
enum class ProbeReading {
  kUnknown,   ///< It does not say.
  kMissing,   ///< No probe is configured: the object model lists none.
  kFree,      ///< Not triggered.
  kTriggered  ///< It reads as if something were touched.
};

/// Asks RepRapFirmware's object model for the value of the first probe.
inline constexpr char kAskProbe[] = R"(M409 K"sensors.probes[0].value[0]")";

/// The answer to kAskProbe: 1000 is triggered, 0 is free, null is no probe.
ProbeReading ProbeReadingOf(std::span<const std::string> answer);

}  // namespace caltwin

#pragma once

#include <array>
#include <string_view>

#include "calibration/loop/bench.h"
#include "calibration/loop/outcome.h"
#include "tools/server/http.h"

namespace caltwin {

/// Whether the firmware's settings are those that this engine reads and writes by axis.
bool HasAxisSettings(const Bench& bench);

/// Writes what differs from what the firmware has.
Expected<void> WriteSettings(Link* link,
                             const Machine& machine,
                             const Settings& wanted);

/// What a job answers that failed before its procedure could.
ProcedureResult ResultOf(const Expected<void>& done);

/// `now`, with what the body of PATCH /api/bench/settings changes: steps/mm at most a
/// factor of two from what they are, gaps and deflections below 5 mm. Beyond, a number
/// was mistyped: throws Problem.
Settings SettingsAsked(const HttpRequest& request, const Settings& now);

/// What the lines of a procedure do to the settings: which of them are off for the time
/// of a measurement alone.
class SettingsWatch {
 public:
  /// From now on; `measures`: whether gaps are set to 0 for a measurement.
  void Begin(bool measures);
  /// Whether the line writes a setting: "M92 X800", "M425 X0.02", "set global.nxt...".
  bool Sees(std::string_view line);
  /// What is to stay of `now`, where `kept` was before.
  Settings Lasting(Settings now, const Settings& kept) const;

 private:
  bool measures_ = false;
  std::array<bool, 3> is_off_{};
};

}  // namespace caltwin

#pragma once

#include <map>
#include <string>

#include "sim/base/input_error.h"
#include "sim/measure/data_header.h"
#include "sim/measure/import/console_line.h"

namespace caltwin {

/// What `M503` of Marlin lists (M92, M665, M666, M851, M425, M852); the last of a kind
/// counts.
class ConsoleSettings {
 public:
  explicit ConsoleSettings(std::string name) : name_(std::move(name)) {}

  /// Takes the line where it is such a setting. Faults go to `faults`.
  bool Take(const ConsoleLine& line, const Place& place, Faults* faults);

  bool has_geometry() const { return places_.contains("M665"); }
  bool has_steps() const { return !in_force_.steps_per_mm.empty(); }
  const SettingsInForce& in_force() const { return in_force_; }

  /// A delta's machine file of M665 and M666 (endstop = H - M666), else a cartesian
  /// machine of M92; empty where neither is known.
  std::string MachineText(Faults* faults) const;

 private:
  double Number(const std::string& word, double fallback) const;
  std::string DeltaText(Faults* faults) const;
  std::string CartesianText() const;

  std::string name_;
  SettingsInForce in_force_{};
  std::map<std::string, double> numbers_{};  ///< "M92X": 80.
  std::map<std::string, Place> places_{};
};

}  // namespace caltwin

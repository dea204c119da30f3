#pragma once

#include <string>
#include <vector>

namespace caltwin {

/// A person's printer.cfg on the twin's pins.
struct AdaptedConfig {
  std::string text{};
  /// What is otherwise than the person wrote it, a line each.
  std::vector<std::string> changes{};
};

/// Puts a printer.cfg, with what it includes, on the pins of a machine of which `drawn`
/// is the printer.cfg as drawn. What only moves, measures and computes stays as it is,
/// macros too. A motor, an endstop and a probe get the twin's pins: its own senses are
/// taken for right. Fans, drivers, displays and other boards are left out, and what
/// SAVE_CONFIG wrote of them; extruder and bed never heat. The commands to them that
/// macros say do nothing.
///
/// A probe is where the nozzle is: it has no x_offset and y_offset, and the twin's
/// z_offset. Where the twin has the switch of Z at the other end, Z homes by the probe.
AdaptedConfig AdaptedToTwin(const std::string& config, const std::string& drawn);

}  // namespace caltwin

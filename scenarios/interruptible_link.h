#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include "scenarios/interrupt.h"
#include "sim/link/link.h"

namespace caltwin {

/// Whether a line moves nothing, and puts back what was set for the time of a
/// measurement: accelerations (M201), compensation of a gap (M425), delays (M816), a
/// nozzle's offset (SET_GCODE_OFFSET without MOVE).
inline bool PutsBack(std::string_view line) {
  return line.starts_with("M201 ") || line.starts_with("M425 ") ||
         line.starts_with("M816 ") ||
         (line.starts_with("SET_GCODE_OFFSET Z=") &&
          line.find("MOVE") == std::string_view::npos);
}

/// Passes everything on, but lets nothing through once Ctrl-C was pressed, so that a
/// procedure ends at its next line, as if the link were lost, and the work done so far
/// is kept. But for what PutsBack.
class InterruptibleLink final : public Link {
 public:
  /// `inner` is borrowed.
  explicit InterruptibleLink(Link* inner) : inner_(inner) {}
  Expected<std::vector<std::string>> Send(std::string_view line,
                                          std::chrono::milliseconds patience) override {
    if (InterruptRequested() && !PutsBack(line)) {
      return tl::unexpected(MachineFault{MachineFault::Kind::kLinkLost, "interrupted"});
    }
    return inner_->Send(line, patience);
  }

 private:
  Link* inner_;
};

}  // namespace caltwin

#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include "scenarios/interrupt.h"
#include "sim/link/link.h"

namespace caltwin {

/// Passes everything on, but lets nothing through once Ctrl-C was pressed: a procedure
/// ends at its next line, as if the link were lost, and the work done so far is kept.
class InterruptibleLink final : public Link {
 public:
  /// `inner` is borrowed.
  explicit InterruptibleLink(Link* inner) : inner_(inner) {}
  Expected<std::vector<std::string>> Send(std::string_view line,
                                          std::chrono::milliseconds patience) override {
    if (InterruptRequested()) {
      return tl::unexpected(MachineFault{MachineFault::Kind::kLinkLost, "interrupted"});
    }
    return inner_->Send(line, patience);
  }

 private:
  Link* inner_;
};

}  // namespace caltwin

#pragma once

#include "scenarios/kinds/triple_z_wire.h"
#include "tools/commands/twin_options.h"

namespace caltwin {

/// A simulated triple-Z printer with its controller, which believes the screws to stand
/// where the drawing has them.
class SimulatedPrinter {
 public:
  /// Reads the files that `named` names. Throws InputError; of truths with what acts by
  /// times or temperatures too, which a controller's wire has not: they would not act.
  explicit SimulatedPrinter(const TwinOptions& named);

  const Machine& machine() const { return plant_.built().machine; }
  Link& link() { return wire_; }

 private:
  TripleZTwinPlant plant_;
  Firmware firmware_;
  EmulatedLink wire_;
};

}  // namespace caltwin

#pragma once

#include "scenarios/kinds/triple_z_wire.h"
#include "tools/commands/twin_options.h"

namespace caltwin {

/// A triple-Z printer as the files that `named` names have it built, its settings what
/// its firmware believes. Throws InputError; of truths with what acts by times or
/// temperatures too, which no controller's wire has: they would not act.
BuiltTripleZ BuiltPrinter(const TwinOptions& named);

/// A simulated triple-Z printer with its controller, which believes the screws to stand
/// where the drawing has them.
class SimulatedPrinter {
 public:
  /// Throws InputError as BuiltPrinter does.
  explicit SimulatedPrinter(const TwinOptions& named);

  const Machine& machine() const { return plant_.built().machine; }
  Link& link() { return wire_; }

 private:
  TripleZTwinPlant plant_;
  Firmware firmware_;
  EmulatedLink wire_;
};

}  // namespace caltwin

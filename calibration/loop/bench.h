#pragma once

#include <functional>
#include <string>
#include <vector>

#include "calibration/loop/kept.h"
#include "calibration/loop/ledger.h"
#include "sim/link/link.h"
#include "sim/machine/artefact.h"
#include "sim/machine/machine.h"
#include "sim/measure/instrument.h"
#include "sim/measure/row.h"

namespace caltwin {

/// All that a calibration has to work with: a wire, instruments, a person, and the
/// papers: the machine's drawing, the artefacts' certificates and nominal places. The
/// pointers are borrowed and never null, but for `record`.
struct Bench {
  Link* link = nullptr;
  Gauge* gauge = nullptr;
  Operator* person = nullptr;
  Machine machine{};
  std::vector<Artefact> artefacts{};
  Instruments instruments{};
  RowTable* record = nullptr;  ///< Every reading is added, where there is one.
  Ledger ledger{};             ///< From one procedure to the next.
  Kept kept{};                 ///< Likewise, of what only one kind of machine has.
  std::function<void(const std::string&)> say = [](const std::string&) {
  };
};

}  // namespace caltwin

#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "sim/effects/effect.h"
#include "sim/kinds/delta/plant.h"
#include "sim/measure/data_header.h"
#include "sim/measure/row.h"
#include "sim/twin/twin.h"

namespace caltwin {

/// A delta that measures.
struct DeltaPerformConfig {
  Machine machine{};
  BuiltDelta built{};  ///< Play among the effects, not here.
  /// More of it: those that turn the build are built in, play of carriages too in
  /// physics; the others (drives, probe, temperatures) act in closed form.
  std::vector<Injected> effects{};
  DataHeader header{};
  Fidelity fidelity = Fidelity::kPhysics;
  std::uint64_t seed = 1;
  bool is_noisy = true;          ///< As PerformConfig.
  std::size_t already_read = 0;  ///< As PerformConfig.
  std::function<bool()> interrupted{};
};

/// Takes every reading of `planned`, as Perform does on a cartesian machine.
///
/// A gauge reads where the nozzle is beside its commanded place. A touch goes straight
/// down, by the firmware's settings, until the nozzle meets the bed. fast: the exact
/// six-rod chain; physics: MuJoCo's rods and contact. What does not turn the build is
/// added in closed form. Throws InputError where the rods do not reach.
RowTable PerformDelta(const DeltaPerformConfig& config, std::vector<Row> planned);

}  // namespace caltwin

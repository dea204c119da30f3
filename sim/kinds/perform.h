#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "sim/effects/effect.h"
#include "sim/machine/machine.h"
#include "sim/measure/data_header.h"
#include "sim/measure/row.h"
#include "sim/twin/twin.h"

namespace caltwin {

/// A twin that measures: how it is built, and what the rows are taken with.
struct PerformConfig {
  Machine machine{};
  std::vector<Injected> effects{};
  /// Instruments by campaign, certificates of artefacts, settings in force by id.
  DataHeader header{};
  Fidelity fidelity = Fidelity::kPhysics;
  std::uint64_t seed = 1;
  /// Whether readings have what only chance and counting give them: noise and
  /// resolution of instruments, scatter of the trigger, whole motor steps. Off for a
  /// replay, whose readings are what the model says and nothing else.
  bool is_noisy = true;
  /// So many rows at the beginning were read before: they are left as they are, and
  /// tell only of the session that goes on (its temperatures, its homings).
  std::size_t already_read = 0;
  /// Asked before each row; true ends it (the rows done so far are returned).
  std::function<bool()> interrupted{};
};

/// The reading of a touch for which the closed form, asked at the trigger it implies,
/// gives that same reading [mm].
double ClosedFormTouch_mm(const Machine& machine,
                          std::span<const Injected> effects,
                          const Row& row,
                          At at);

/// Takes every reading of `planned` in its order, whatever `value_mm` says, and fills
/// in what was read. Rows may come from a plan or from a file: a sense not known leaves
/// the axis in the middle of its gap, a coordinate not known is mid-travel, settings
/// not explained are the machine file's.
///
/// fast: the measurement model's closed form (sim/effects/predict.h), solved for the
/// reading where errors depend on it (a touch is taken where it triggers). physics:
/// MuJoCo's kinematics and contact: a small block stands where the row says the surface
/// is, in that direction and on the table; the machine comes in the sense that the row
/// says and touches it. Throws InputError where a row does not say in which direction
/// it is measured.
RowTable Perform(const PerformConfig& config, std::vector<Row> planned);

}  // namespace caltwin

#pragma once

#include <functional>
#include <optional>

#include "calibration/kinds/delta/bench.h"
#include "calibration/kinds/delta/joint.h"
#include "calibration/kinds/delta/steps.h"
#include "calibration/loop/outcome.h"
#include "sim/link/link.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/measure/kinds/delta_rows.h"

namespace caltwin {

/// What a controller says that it believes.
struct BelievedDelta {
  DeltaModel<double> settings{};
  Vec3<double> probe_offset_mm = Vec3<double>::Zero();
};

/// All that calibrates a delta of which only a wire is known. The pointers are borrowed
/// and never null, but for `record` and `fit`. Procedures on a Bench take what is put
/// there (Bench::kept), its link, person and machine the bench's own.
struct DeltaBench {
  Link* link = nullptr;
  Operator* person = nullptr;  ///< Is asked before settings are changed.
  DeltaCalliper calliper{};    ///< A reading that nobody gives is nullopt.
  Machine machine{};           ///< As drawn.
  double probe_sigma_mm = 0;
  DeltaRecord* record = nullptr;  ///< Every G30 is added, where there is one.
  /// What the controller believes, to the last digit; without it M503 is asked.
  std::function<BelievedDelta()> believed{};
  /// What a joint estimate found beside its result is left here.
  std::optional<DeltaJointFit>* fit = nullptr;
};

/// Reads M503's lines M665, M666 and M851, as Marlin prints them:
///
///   endstop_i = H - M666_i,  arm_i = L + A B C,  angle_i = drawn + X Y Z,  radius = R
///
/// Refused where M665 or M666 are not among them. Marlin prints few decimals: what it
/// keeps beyond them is an error of the settings that nobody sees.
Expected<BelievedDelta> ReadBelievedDelta(Link* link, const DeltaModel<double>& drawn);

/// Performs one step over the wire: reads what the controller believes, touches (G28,
/// G30) or lets it run G33, and, where the person agrees, sends M665, M666 and stores
/// them (M500). Where the person refuses nothing is sent, and a G33 is run dry (V0).
/// Figures: `said_mm`, its own deviation; `tilt_x`, `tilt_y`, of the bed as found.
ProcedureResult CalibrateDelta(const DeltaStep& step, const DeltaBench& bench);

}  // namespace caltwin

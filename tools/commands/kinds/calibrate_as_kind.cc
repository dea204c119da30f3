#include "tools/commands/kinds/calibrate_as_kind.h"

#include "sim/machine/kinds/kinds.h"
#include "sim/machine/kinds/triple_z/drawing.h"
#include "tools/commands/kinds/calibrate_delta.h"
#include "tools/commands/kinds/calibrate_motors.h"
#include "tools/commands/kinds/calibrate_triple_z.h"
#include "tools/commands/kinds/calibrate_z_offset.h"

namespace caltwin {

std::optional<int> CalibrateAsKind(const CalibrateOptions& options) {
  if (const auto stage = MotorStageToCalibrate(options)) {
    return CalibrateMotorsAtHand(options, *stage);
  }
  // A station may stand at any printer: its procedures tell.
  if (IsZStation(options)) return CalibrateZStationAtHand(options);
  const auto file = MachineToCalibrate(options);
  if (!file) return std::nullopt;
  if (file->machine.kind == DeltaKind()) return CalibrateDeltaAtHand(options, *file);
  if (file->machine.Own<TripleZDrawing>() != nullptr) {
    return CalibrateTripleZAtHand(options, *file);
  }
  return std::nullopt;
}

}  // namespace caltwin

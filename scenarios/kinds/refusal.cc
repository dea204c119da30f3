#include "scenarios/kinds/refusal.h"

#include "sim/base/input_error.h"
#include "sim/machine/kinds/kinds.h"
#include "sim/machine/kinds/triple_z/drawing.h"

namespace caltwin {

void RequireGantry(const Machine& machine, const std::filesystem::path& file) {
  if (machine.Own<TripleZDrawing>() != nullptr) {
    throw InputError(
        {.file = file.string()},
        "this machine has its bed on three screws, which this command "
        "does not know",
        "run, calibrate, serve, compare levelling, simulate, plan, diagnose "
        "(closed loops too), validate and render know it");
  }
  if (machine.kind == ZStationKind()) {
    throw InputError(
        {.file = file.string()},
        "this machine is a printer's station of nozzle, switch and probe, which this "
        "command does not know",
        "run, calibrate (z_calibration, probe_accuracy, switch_offset), serve, "
        "simulate, plan, diagnose, validate and render know it");
  }
  if (machine.kind == DeltaKind()) {
    throw InputError(
        {.file = file.string()},
        "this machine is a delta, which this command does not know",
        "run, calibrate, serve, compare delta, simulate, plan, diagnose (closed loops "
        "too), validate, render and import klipper-delta know deltas");
  }
}

}  // namespace caltwin

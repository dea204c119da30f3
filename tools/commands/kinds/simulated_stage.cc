#include "tools/commands/kinds/simulated_stage.h"

namespace caltwin {
namespace {

MotorStageTruth TruthOf(const MotorStageDrawing& drawing, const TwinOptions& named) {
  return named.truth.empty() ? MotorStageTruth{.drawing = drawing}
                             : ReadMotorTruthFile(named.truth, drawing);
}

}  // namespace

SimulatedStage::SimulatedStage(const MotorStageDrawing& drawing,
                               const TwinOptions& named,
                               double sigma_unit)
    : SimulatedStage(TruthOf(drawing, named), named, sigma_unit) {}

SimulatedStage::SimulatedStage(const MotorStageTruth& truth,
                               const TwinOptions& named,
                               double sigma_unit)
    : rig_(DrawMotorStage(truth, named.seed, /*sample=*/0),
           named.fidelity == "physics",
           named.seed,
           /*sample=*/0),
      firmware_(MotorFirmwareOf(truth.drawing), &rig_, &flash_),
      wire_(&firmware_),
      gauge_(&rig_, sigma_unit, named.seed, /*sample=*/0) {
  MotorAxes axes({.link = &wire_, .drawing = truth.drawing});
  SetFields(truth, named.truth, &axes);
}

}  // namespace caltwin

#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "calibration/kinds/delta/joint.h"
#include "scenarios/judge.h"
#include "scenarios/kinds/delta_scenario.h"
#include "scenarios/result.h"
#include "sim/kinds/delta/plant.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {

/// Where a run has led, for those who know the truth.
struct DeltaTruth {
  const Machine& machine;
  const BuiltDelta& built;
  DeltaModel<double> before{};         ///< Settings when the firmware was switched on,
  DeltaModel<double> after_first{};    ///< after the first step,
  DeltaModel<double> after{};          ///< and at the end.
  DeltaMesh mesh{};                    ///< That the firmware lifts by at the end.
  std::optional<DeltaJointFit> fit{};  ///< Of the last step.
  std::vector<Estimate> settings_told{};  ///< By the last step, uncertainty and all.
  std::vector<Correlations> correlations{};
  /// By the last procedure, as its own deviation; nullopt: none says one.
  std::optional<double> said_mm{};
  double tilt_x = 0,
         tilt_y = 0;  ///< Of the bed, found by the last step, not commanded.
};

/// The largest of 95 % of the nozzle's errors at 1000 seeded poses over the bed, up to
/// as high as it is wide, carriages with play having come down or up by chance; the
/// mean error is left out. Infinite where the machine does not reach.
double DeltaPositionP95_mm(const DeltaTruth& trial,
                           const DeltaModel<double>& settings,
                           const DeltaMesh& mesh);

/// By how much the nozzle's height over the bed differs at most between moves down and
/// moves up to the same place: what is lost in the play of carriages. 0: none is, or
/// all hang. Infinite where the machine does not reach.
double DeltaReversal_mm(const DeltaTruth& trial);

/// The rows of settings, and of what the joint estimate knows beside them.
void AddDeltaTable(const DeltaTruth& truth, RunResult* result);

/// The figure is the nozzle's height over the bed, rms: a tenth of what it was.
TrueEnd EndOfDelta(const DeltaTruth& truth, RunResult* result);

double FigureOfDelta(const DeltaTruth& truth,
                     const std::string& name,
                     const RunResult& result);

}  // namespace caltwin

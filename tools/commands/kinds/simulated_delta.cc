#include "tools/commands/kinds/simulated_delta.h"

#include <utility>

#include "scenarios/kinds/delta_scenario.h"
#include "sim/base/units.h"
#include "sim/machine/kinds/delta/drawing.h"

namespace caltwin {

DeltaPerformConfig MakeDeltaConfig(const MachineFile& file,
                                   const TwinOptions& options) {
  DeltaEffects truth;
  if (!options.truth.empty()) truth = ReadDeltaTruthFile(options.truth, file.machine);
  truth.effects.insert(truth.effects.end(), file.effects.begin(), file.effects.end());
  DrawnDelta drawn = DrawDelta(truth, file.machine, options.seed, /*sample=*/0);
  return {.machine = file.machine,
          .built = drawn.built,
          .effects = std::move(drawn.others),
          .fidelity = options.fidelity == "fast" ? Fidelity::kFast : Fidelity::kPhysics,
          .seed = options.seed};
}

DeltaTwinConfig MakeDeltaTwinConfig(const MachineFile& file,
                                    const TwinOptions& options) {
  DeltaScenario scenario;
  scenario.settings = DeltaOf(file.machine).settings;
  scenario.probe_sigma_mm = ProbeSigma_mm(options.instruments);
  if (!options.truth.empty()) {
    scenario.effects = ReadDeltaTruthFile(options.truth, file.machine);
  }
  std::vector<InjectedSpec>& all = scenario.effects.effects;
  all.insert(all.end(), file.effects.begin(), file.effects.end());
  Faults faults;
  RequireDeltaParts(scenario.effects, &faults);
  faults.ThrowIfAny();
  return {.machine = file.machine,
          .built = DrawDelta(scenario, file.machine, options.seed, /*sample=*/0),
          .settings = scenario.settings,
          .calliper_sigma_mm = CalliperSigma_mm(options.instruments),
          .fidelity = options.fidelity == "fast" ? Fidelity::kFast : Fidelity::kPhysics,
          .seed = options.seed};
}

double CalliperSigma_mm(const Instruments& instruments) {
  const auto calliper = instruments.find("calliper");
  return calliper == instruments.end() ? DeltaTwinConfig{}.calliper_sigma_mm
                                       : MmFromUm(calliper->second.sigma_um);
}

}  // namespace caltwin

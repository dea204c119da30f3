#include "tools/commands/kinds/performer.h"

#include <utility>

#include "sim/kinds/perform.h"
#include "sim/machine/kinds/kinds.h"
#include "tools/commands/kinds/simulated_delta.h"

namespace caltwin {
namespace {

template <typename Config>
Config With(Config config, const ToPerform& with) {
  config.header = with.header;
  config.seed += with.already_read;
  config.already_read = with.already_read;
  config.interrupted = with.interrupted;
  return config;
}

Performer DeltaPerformer(const MachineFile& file, const TwinOptions& options) {
  const DeltaPerformConfig config = MakeDeltaConfig(file, options);
  return {.machine = file.machine,
          .perform = [config](const ToPerform& with, std::vector<Row> planned) {
            return PerformDelta(With(config, with), std::move(planned));
          }};
}

}  // namespace

Performer PerformerOf(const MachineFile& file, const TwinOptions& options) {
  if (file.machine.kind == DeltaKind()) return DeltaPerformer(file, options);
  std::vector<InjectedSpec> effects = file.effects;
  std::vector<SettingSpec> settings;
  if (!options.truth.empty()) {
    const TruthFile truth = ReadTruthFile(options.truth, file.machine);
    effects.insert(effects.end(), truth.effects.begin(), truth.effects.end());
    settings = truth.settings;
  }
  PerformConfig config{
      .machine = file.machine,
      .effects = DrawEffects(effects, options.seed, 0),
      .fidelity = options.fidelity == "fast" ? Fidelity::kFast : Fidelity::kPhysics,
      .seed = options.seed};
  config.machine.settings =
      DrawSettings(file.machine.settings, settings, options.seed, /*sample=*/0);
  return {.machine = config.machine,
          .perform = [config](const ToPerform& with, std::vector<Row> planned) {
            return Perform(With(config, with), std::move(planned));
          }};
}

}  // namespace caltwin

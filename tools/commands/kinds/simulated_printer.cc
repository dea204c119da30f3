#include "tools/commands/kinds/simulated_printer.h"

#include <string>
#include <vector>

#include <fmt/format.h>

#include "sim/effects/catalog.h"
#include "sim/machine/kinds/triple_z/drawing.h"

namespace caltwin {
namespace {

void RequireTimeless(const std::vector<Injected>& effects, const std::string& truth) {
  for (const Injected& injected : effects) {
    const Effect& effect = EffectAt(injected.effect);
    if (effect.bucket != Bucket::kTime && effect.name != "probe_temperature") continue;
    throw InputError({.file = truth},
                     fmt::format("'{}' needs times or temperatures, which levelling a "
                                 "twin has not",
                                 effect.name),
                     "`caltwin simulate --truth` has them");
  }
}

}  // namespace

BuiltTripleZ BuiltPrinter(const TwinOptions& named) {
  const TwinConfig config = MakeTwinConfig(named, /*only_measures=*/true);
  RequireTimeless(config.effects, named.truth);
  BuiltTripleZ built{.machine = config.machine,
                     .effects = config.effects,
                     .scatter_mm = ProbeSigma_mm(config.instruments)};
  built.machine.settings = config.settings;
  return built;
}

SimulatedPrinter::SimulatedPrinter(const TwinOptions& named)
    : plant_(
          BuiltPrinter(named), named.fidelity == "physics", named.seed, /*sample=*/0),
      firmware_(machine(),
                machine().settings,
                FirmwareOnScrews(TripleZOf(machine()).pivots_mm()),
                &plant_),
      wire_(&firmware_) {}

}  // namespace caltwin

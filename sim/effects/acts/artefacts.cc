#include "sim/effects/acts/artefacts.h"

#include "sim/base/units.h"
#include "sim/effects/catalog.h"

namespace caltwin {

std::vector<Artefact> BuiltArtefacts(std::vector<Artefact> drawn,
                                     std::span<const Injected> effects) {
  for (Artefact& artefact : drawn) {
    for (const Injected& injected : effects) {
      const bool is_named = injected.axis.empty() || injected.axis == artefact.id;
      if (!is_named) continue;
      if (injected.effect == EffectIndex<BlockSize>()) {
        artefact.size_mm.array() += MmFromUm(injected.values[0]);
      }
      if (injected.effect == EffectIndex<BlockRotated>()) {
        artefact.turn_deg += DegFromRad(RadFromMrad(injected.values[0]));
      }
    }
  }
  return drawn;
}

}  // namespace caltwin

#include "sim/effects/acts/artefacts.h"

#include "sim/base/units.h"
#include "sim/effects/catalog.h"

namespace caltwin {

namespace {

// Each size by its own; the block may lie on any side.
void AddOff(Artefact* artefact) {
  const Vec3<double> certified_mm = artefact->size_mm;
  for (int i = 0; i < 3; ++i) {
    const auto rank = (certified_mm.array() < certified_mm[i]).count();
    artefact->size_mm[i] += artefact->off_mm[static_cast<std::size_t>(rank)];
  }
}

}  // namespace

std::vector<Artefact> BuiltArtefacts(std::vector<Artefact> drawn,
                                     std::span<const Injected> effects) {
  for (Artefact& artefact : drawn) {
    if (artefact.type == ArtefactType::kBlock123) AddOff(&artefact);
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

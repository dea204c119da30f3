#pragma once

#include <span>
#include <vector>

#include "sim/effects/effect.h"
#include "sim/machine/artefact.h"

namespace caltwin {

/// Artefacts as they are built and lie: as drawn, with what the effects do to them.
/// block_size changes every size (thickness and bore included), block_rotated the turn
/// about the middle of the base. Both fidelities make their solids of these.
std::vector<Artefact> BuiltArtefacts(std::vector<Artefact> drawn,
                                     std::span<const Injected> effects);

}  // namespace caltwin

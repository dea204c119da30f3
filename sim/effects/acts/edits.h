#pragma once

#include "sim/effects/effect.h"
#include "sim/mjcf/mjcf.h"

namespace caltwin {

/// @name Edits of the model, one an effect; each has its own file.
void EditBacklash(const Machine& machine, const Injected& injected, Mjcf* model);
void EditWindupLoad(const Machine& machine, const Injected& injected, Mjcf* model);
void EditSquareness(const Machine& machine, const Injected& injected, Mjcf* model);
void EditRacking(const Machine& machine, const Injected& injected, Mjcf* model);
void EditStraightness(const Machine& machine, const Injected& injected, Mjcf* model);
void EditAngular(const Machine& machine, const Injected& injected, Mjcf* model);
void EditGantrySag(const Machine& machine, const Injected& injected, Mjcf* model);
void EditAxisTwist(const Machine& machine, const Injected& injected, Mjcf* model);
void EditTipSize(const Machine& machine, const Injected& injected, Mjcf* model);
void EditBedTilt(const Machine& machine, const Injected& injected, Mjcf* model);

}  // namespace caltwin

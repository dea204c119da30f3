#pragma once

#include "calibration/diagnosis/candidates.h"

namespace caltwin {

/// What any name must beat any free form by [nats of log odds]. A free form's prior
/// weight and handicap come to some eight, so at five it wins only where it explains
/// the rows clearly better.
inline constexpr double kOwnShape_nats = 5;

/// By how many nats of log odds a name must beat this free form; below, the free form
/// tells the same story, and the name is one of many.
///
/// More than `kOwnShape_nats` is asked of a name where the free form speaks of
/// something else than the name's own shape:
///  - what acts along every normal (a probe) against a free form of one axis alone: it
///    has to be seen on faces of more than one axis;
///  - position with temperature against the same with time: it has to follow the
///    thermometer, not only the clock.
double MarginOver(const Candidate& named, const Candidate& free);

/// Whether both are seen in the same rows and vary with the same thing, so that one can
/// take up what the other leaves. Time and temperature count as the same: after a
/// warm-up no row tells them apart. A delta's tower moves the nozzle along every axis,
/// and where its carriage stands is a matter of place.
bool ShareRowsAndVariable(const Shown& one, const Shown& other);

}  // namespace caltwin

#pragma once

#include "calibration/procedures/span.h"

namespace caltwin {

/// The thickness of a ledge's lip, touched from above and, coming in from beside, from
/// below, both with the disc stylus, which the operator fits and takes off again.
///
/// A flat disc meets a tilted lip at its rim, and the two touches lie apart, so a tilt
/// of 1 mrad would read 30 um off. The lip's own slopes, from four touches of its top,
/// take that away:
///
///   span = t + v_top + v_bottom - r |s| + s . (c - p)
///
/// v the readings along the outward normals at the lip's middle p and beneath it, s the
/// slope, r the disc's radius, c where the disc first meets the underside. Neglects the
/// curvature of the lip and the second order of the slope.
Expected<SpanReading> MeasureLedge(Session* session,
                                   const Artefact& ledge,
                                   const SpanPlan& plan);

}  // namespace caltwin

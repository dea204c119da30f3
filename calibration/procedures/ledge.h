#pragma once

#include <vector>

#include "calibration/estimate/observation.h"
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

/// Rows of MeasureLedge, made ready for the joint estimate: `observations`, one for
/// each of `rows`, read as if the lip were level at its middle. Its own slopes come
/// from the rows of its top; other rows stay as they are.
void LevelLedge(const Artefact& ledge,
                double disc_radius_mm,
                const std::vector<Row>& rows,
                std::vector<Observation>* observations);

}  // namespace caltwin

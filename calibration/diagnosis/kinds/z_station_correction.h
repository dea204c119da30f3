#pragma once

#include <string>

#include "calibration/diagnosis/controller.h"
#include "calibration/diagnosis/diagnosis.h"

namespace caltwin {

/// What Klipper's z_calibration is told, from what a diagnosis found of a printer's
/// station:
///
///   [z_calibration] switch_offset = the one in force + what it was found off by   [mm]
///
/// In force is what the rows' header states (`settings: {s1: {switch_offset_mm: }}`),
/// else the machine file's `station: {trigger_mm: }`. Where the header states several,
/// only by how much to change it is written, as a comment. Everything else at a station
/// is mended or waited for, not set: comments say what to do. Throws as
/// RequireZCalibration does.
std::string ZStationCorrectionText(ControllerKind controller,
                                   const Diagnosis& diagnosis,
                                   const Observed& observed);

/// Throws InputError of a controller that knows no switch_offset: all but Klipper.
void RequireZCalibration(ControllerKind controller);

}  // namespace caltwin

#pragma once

#include "sim/measure/import/import.h"

namespace caltwin {

/// A whole row or column of a printed mesh that is exactly 0, where the mesh is not:
/// the firmware printed what it had not stored. Such readings are taken out, and a note
/// says so, with what another mesh of the same places has there.
void TellUnmeasuredLines(Imported* imported);

}  // namespace caltwin

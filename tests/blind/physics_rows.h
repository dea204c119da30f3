#pragma once

#include <string>
#include <vector>

#include "tests/blind/case.h"

namespace blind {

/// What `caltwin simulate` wrote: rows, and the header that explains them.
struct RunFiles {
  std::string rows{}, header{};
};

/// Fills a case's stops, placements, certificates, times, temperatures and readings
/// from the rows of a run.
void ReadRun(const RunFiles& files, Case* made);

/// The readings alone [mm].
std::vector<double> ValuesOf(const RunFiles& files);

/// A reading becomes `value_mm`; a touch ends where that says.
void SetValue(double value_mm, const Drawing& drawing, Reading* reading);

}  // namespace blind

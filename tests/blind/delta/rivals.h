#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tests/blind/delta/case.h"
#include "tests/blind/visible.h"

namespace blind {

/// A cause that is never hidden here and that a diagnosis may name all the same.
struct DeltaRival {
  std::string name{};
  /// Readings that it would add, one column for each form it may have (a time constant,
  /// a sensor), in sigma of a reading for a size of 1 um or 1 um/K.
  std::vector<Column> forms{};
};

/// What else grows as a warming frame does, in the truth's own words: a machine that
/// grows with time and levels off, and a probe that grows with any temperature logged.
/// Gauges read how high the nozzle stands, touches how low the bed.
std::vector<DeltaRival> DeltaRivals(const std::vector<DeltaStop>& stops,
                                    double sigma_mm);

}  // namespace blind

#pragma once

#include <string>
#include <string_view>

#include "calibration/diagnosis/search.h"

namespace caltwin {

/// What is in inches or their thousandths where a stated uncertainty is `ratio` times
/// the scatter of the readings; empty where no inch explains that.
std::string_view InchesBy(double ratio);

/// What to say where readings scatter ten times more, or less, than their instruments
/// are stated to; empty where they do not, or nothing is stated. A size that was found
/// is in the readings' unit: where that is wrong, so is the size, and nothing else
/// shows it.
std::string RemarkOnStatedNoise(const Observed& observed, const SearchResult& search);

}  // namespace caltwin

#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "calibration/facts/cells.h"
#include "calibration/facts/repeats.h"

namespace caltwin {

/// Touches of a surface by place, x and y in hundredths of a millimetre, in the order
/// measured.
using HeightMap = std::map<std::pair<long, long>, Rows>;

/// Of each campaign, in the order of their first touches; bad readings left out.
std::vector<std::pair<std::string, HeightMap>> HeightMapsOf(const Rows& rows,
                                                            const Repeats& repeats);

}  // namespace caltwin

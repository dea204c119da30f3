#pragma once

#include <string>

#include "sim/measure/import/import.h"

namespace caltwin {

/// Reads heightmap.csv of RepRapFirmware: a line of words that names the file, a line
/// of names (`xmin,xmax,ymin,ymax,radius,xspacing,yspacing,xnum,ynum`, or those of
/// later versions, `axis0,axis1,min0,...`), a line of their numbers, then a line of
/// heights for each y, upwards. A bare `0` was not probed (a probed nought is `0.000`)
/// and is left out. `touch` of bed.top, value = height, + is up.
Imported ReadRrfHeightmap(const std::string& text,
                          const std::string& name,
                          const ImportOptions& options);

}  // namespace caltwin

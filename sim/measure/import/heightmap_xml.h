#pragma once

#include "sim/measure/import/import.h"

namespace caltwin {

/// Reads a height map as senders for grbl save it: `<heightmap MinX MinY MaxX MaxY
/// SizeX SizeY>` with a `<point X Y>height</point>` for each node, X and Y counted from
/// 0, lengths in mm. Points that hold no number were not probed and are left out.
/// Throws InputError where the text is no such map or a point lies outside its grid.
Imported ReadHeightmapXml(const std::string& text,
                          const std::string& name,
                          const ImportOptions& options);

}  // namespace caltwin

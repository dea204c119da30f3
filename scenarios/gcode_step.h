#pragma once

#include <string>
#include <vector>

#include "calibration/procedures/catalog.h"
#include "sim/base/yaml.h"

namespace caltwin {

/// Reads the options of a `gcode` step, `{lines: [M500, M999]}`: lines sent as they
/// are, one after the other, until one is refused. What the machine answers becomes the
/// run's messages.
PreparedProcedure ReadGcodeStep(YamlMap options);
/// The same of those lines.
PreparedProcedure GcodeStep(std::vector<std::string> lines);

}  // namespace caltwin

#pragma once

#include <string>

#include "calibration/procedures/catalog.h"
#include "calibration/procedures/options.h"

namespace caltwin {

struct DialOptions {
  CommonOptions common{};
  std::string instrument = "dial";  ///< dial | laser
};

/// Backlash of one axis by a dial or a laser: led in, zeroed, on, come back.
Expected<void> RunDial(Session* session, const DialOptions& options);

DialOptions ReadDialOptions(YamlMap* map, const CommonOptions& defaults);

extern const Procedure kDialBacklash;

}  // namespace caltwin

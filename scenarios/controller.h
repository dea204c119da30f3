#pragma once

#include <filesystem>

#include "scenarios/scenario.h"
#include "sim/base/yaml.h"

namespace caltwin {

/// `controller:` of a scenario: {klipper: ...} or {linuxcnc: ...}, a real program that
/// drives the machine in place of `calibrate`. Paths are relative to `folder`.
void ReadController(const YamlValue& value,
                    const std::filesystem::path& folder,
                    Scenario* scenario);

}  // namespace caltwin

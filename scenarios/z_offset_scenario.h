#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "scenarios/delta_scenario.h"
#include "sim/base/yaml.h"
#include "sim/firmware/dialects/klipper_z.h"
#include "sim/kinds/z_station/station.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// One number of a station that a scenario gives, perhaps still to be drawn.
struct StationSpec {
  std::string key{};
  Distribution value = 0.0;
};

/// One entry of such a scenario's `calibrate:`.
struct ZOffsetStep {
  std::string name{};  ///< z_calibration, probe_accuracy, switch_offset, gcode, change.
  std::vector<std::string> lines{};   ///< Of gcode.
  std::vector<StationSpec> change{};  ///< What an operator changes.
  int samples = 10;
  bool is_endstop = true;
  bool applies = true;
  bool is_as_published = false;
};

/// What a scenario of a nozzle's height has of its own (`station:`).
struct ZOffsetScenario {
  std::vector<StationSpec> station{};
  ZCalibrationConfig settings{};
  std::vector<ZOffsetStep> calibrate{};
  std::string outcome = "recovers";
  std::vector<std::pair<std::string, Within>> figures{};  ///< `z_offset_error_mm`, ...
  std::vector<std::string> messages{};
};

/// Reads `station:`, `settings:`, `calibrate:`, `expect:`.
ZOffsetScenario ReadZOffsetScenario(YamlMap* map, const Machine& machine);

/// Reads a list of its steps, as in `calibrate:`.
std::vector<ZOffsetStep> ReadZOffsetSteps(const YamlValue& list);

/// Reads `station: {KEY: number or distribution}`.
std::vector<StationSpec> ReadStation(YamlMap map);

/// Sets what the specs say, each drawn from its own stream.
void SetStation(const std::vector<StationSpec>& specs,
                std::uint64_t seed,
                std::uint64_t sample,
                ZStation* station);

}  // namespace caltwin

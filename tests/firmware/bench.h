#pragma once

#include <string>
#include <vector>

#include "sim/firmware/firmware.h"
#include "tests/firmware/rigid_plant.h"

namespace caltwin {

/// A controller with a rigid machine at its motors.
struct FirmwareBench {
  explicit FirmwareBench(const FirmwareOptions& options = {})
      : plant(machine), firmware(machine, machine.settings, options, &plant) {}

  /// The lines printed in answer to several, sent one after the other.
  std::vector<std::string> Say(const std::vector<std::string>& lines) {
    std::vector<std::string> printed;
    for (const std::string& line : lines) {
      for (std::string& answer : firmware.Execute(line).lines) {
        printed.push_back(std::move(answer));
      }
    }
    return printed;
  }
  /// Homed, at X100 Y100 Z100.
  void HomeAndCentre() { Say({"G28", "G0 X100 Y100 Z100", "M400"}); }

  Machine machine = TestMachine();
  RigidPlant plant;
  Firmware firmware;
};

}  // namespace caltwin

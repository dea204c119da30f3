#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "sim/firmware/plant.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// What distinguishes one controller from another of the same dialect.
struct FirmwareOptions {
  /// RepRapFirmware before 3.6.1 ignored backlash steps when it recomputed the position
  /// after M400.
  bool m400_ignores_backlash = false;
  /// The files of the controller's own storage, by path ("sys/nxt-user-vars.g");
  /// start-up runs nxt-user-vars.g where it is there.
  std::map<std::string, std::string> files{};
};

/// The answer to one line: what the controller prints, and whether it refused.
struct Reply {
  std::vector<std::string> lines{};  ///< Without the final `ok`.
  bool error = false;  ///< A line begins with "Error:" or the machine is in alarm.
};

}  // namespace caltwin

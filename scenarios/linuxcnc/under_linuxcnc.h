#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "scenarios/linuxcnc/host.h"

namespace caltwin {

/// What stands for the program among the lines that LinuxCNC is told.
inline constexpr std::string_view kRunProgram = "run the program";

/// `controller: {linuxcnc: ...}` of a scenario: LinuxCNC drives the machine.
struct UnderLinuxCnc {
  /// Without files: made of the machine, with what `settings` has its firmware believe.
  LinuxCncOptions options{};
  LinuxCncFiles more_files{};  ///< Tables, subroutines.
  std::string program{};       ///< The text of a .ngc file.
  bool is_homed_first = true;
};

}  // namespace caltwin

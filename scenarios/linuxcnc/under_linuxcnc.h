#pragma once

#include <string>
#include <string_view>

#include "scenarios/linuxcnc/host.h"
#include "sim/controllers/linuxcnc/config.h"

namespace caltwin {

/// What stands for the program among the lines that LinuxCNC is told.
inline constexpr std::string_view kRunProgram = "run the program";

/// `controller: {linuxcnc: ...}` of a scenario: LinuxCNC drives the machine.
struct UnderLinuxCnc {
  /// Without files: made of the machine, with what `settings` has its firmware believe.
  LinuxCncOptions options{};
  LinuxCncFiles more_files{};             ///< Tables, subroutines.
  std::string program_name{}, program{};  ///< A .ngc file, and its text.
  bool is_homed_first = true;
};

/// The same with all files: without an INI file of one's own, those of `machine`.
UnderLinuxCnc Completed(UnderLinuxCnc asked, const linuxcnc::MachineText& machine);

}  // namespace caltwin

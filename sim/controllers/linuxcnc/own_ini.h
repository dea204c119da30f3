#pragma once

#include <string>
#include <vector>

#include "sim/controllers/linuxcnc/config.h"

namespace caltwin {
namespace linuxcnc {

/// The machine file of the mill that an INI file is for: travels, steps, feeds, home
/// ends of X, Y and Z, two motors of Y. Of Z the table is `kUnderTable_mm` above the
/// lower end of its travel. Kinematics: trivkins. Throws InputError: it does not say so
/// much, or is of another kind.
/// @param file  what a fault calls it
std::string MachineFileOfIni(const std::string& ini,
                             const std::string& file,
                             const std::string& name);

/// A table of corrections that a joint has as COMP_FILE.
struct OwnTable {
  std::string from{};      ///< As the person's INI file names it.
  std::string name{};      ///< As the new one does.
  bool has_trims = false;  ///< COMP_FILE_TYPE 1: its last two columns are corrections.
  double raised = 0;       ///< By so much the joint counts more, in the file's units.

  /// Its text with places as the joint counts now.
  std::string Raised(const std::string& text) const;
};

/// A person's INI file with caltwin in place of the card.
struct OwnIni {
  std::string ini{}, hal{};
  std::vector<OwnTable> tables{};
  std::vector<std::string> changes{};  ///< What is otherwise than the person wrote it.
};

/// @param drawn  the machine that MachineFileOfIni makes of it
/// Feeds, play, tables, homing, startup code and offsets stay. [HAL] names one file,
/// machine.hal; axes beside X, Y and Z are left out; a joint that is not homed on a
/// switch gets one; Z counts from the table.
OwnIni WithTwin(const std::string& ini, const MachineText& drawn);

}  // namespace linuxcnc
}  // namespace caltwin

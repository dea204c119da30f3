#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "scenarios/machine_file.h"
#include "tools/commands/measured_data.h"

namespace caltwin {

/// The machine that rows are held against, and what its file adds to the drawing.
struct Believed {
  Machine machine{};
  std::vector<InjectedSpec> effects{};
  std::filesystem::path file{};              ///< Empty: assumed from the rows.
  std::map<std::string, double> baseline{};  ///< Of an extension (MachineFile).
};

/// `machine`, which messages call `asked_by`, else the header's `machine:` (relative to
/// the header), else assumed from the rows of `data_file`; what a person should know of
/// it goes to `data->notes`. Throws InputError where rows of motors have none.
Believed BelievedMachine(const std::string& data_file,
                         const std::string& machine,
                         Data* data,
                         const std::string& asked_by = "--machine");

}  // namespace caltwin

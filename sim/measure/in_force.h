#pragma once

#include <string>

#include "sim/machine/machine.h"
#include "sim/measure/data_header.h"

namespace caltwin {

/// The firmware's settings under which a row was measured: the machine file's, the
/// header's tip radius, and over them what the header says of the row's `settings` id.
Settings InForce(const DataHeader& header,
                 const Machine& machine,
                 const std::string& id);

/// The same as a header writes it.
SettingsInForce AsHeader(const Settings& settings, const MachineKind& kind);

}  // namespace caltwin

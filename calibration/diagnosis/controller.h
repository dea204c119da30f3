#pragma once

#include <string_view>

namespace caltwin {

/// The controllers that a correction can be written for.
enum class ControllerKind { kRrf, kKlipper, kMarlin, kLinuxCnc };
/// Throws InputError where the word is none of rrf, klipper, marlin, linuxcnc.
ControllerKind ControllerNamed(std::string_view word);

/// "Marlin".
std::string_view FullName(ControllerKind controller);
/// Whether its settings are G-code; else lines of a configuration file.
bool IsSetByGcode(ControllerKind controller);

}  // namespace caltwin

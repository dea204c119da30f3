#pragma once

#include <filesystem>

#include "sim/machine/machine.h"

namespace caltwin {

/// Throws InputError, saying what knows such a machine, where it is no gantry.
void RequireGantry(const Machine& machine, const std::filesystem::path& file);

}  // namespace caltwin

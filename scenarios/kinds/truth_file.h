#pragma once

#include <filesystem>

namespace caltwin {

/// Reads a truth file (`effects` and `settings` of a scenario, nothing else), which
/// does not say whose it is: as one of the kind of machine that knows most of what it
/// names. Throws InputError with that kind's faults.
void CheckTruthFile(const std::filesystem::path& file);

}  // namespace caltwin

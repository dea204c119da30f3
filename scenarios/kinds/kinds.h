#pragma once

#include <filesystem>
#include <memory>

#include "scenarios/kind_scenario.h"
#include "scenarios/machine_file.h"

namespace caltwin {

/// Reads the machine of a scenario into `machine`, and gives what its kind has of its
/// own, not filled in yet. `file` may be empty: nobody says. `map`: of the scenario,
/// whose keys may tell the kind.
std::unique_ptr<KindScenario> ReadKind(const std::filesystem::path& file,
                                       YamlMap* map,
                                       MachineFile* machine);

/// The kind that is meant where nobody says: a gantry, or another machine that is led
/// as one.
std::unique_ptr<KindScenario> UsualKind(const MachineKind* kind = CartesianKind());

}  // namespace caltwin

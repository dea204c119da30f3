#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "scenarios/kind_scenario.h"
#include "scenarios/machine_file.h"

namespace caltwin {

/// Reads the machine of a scenario into `machine`, and gives what its kind has of its
/// own, not filled in yet. `file` may be empty: nobody says. `map`: of the scenario,
/// whose keys may tell the kind.
std::unique_ptr<KindScenario> ReadKind(const std::filesystem::path& file,
                                       YamlMap* map,
                                       MachineFile* machine);

/// What the scenarios of that machine have of their own, not filled in yet.
/// @param has_station  a printer with a switch under its nozzle, whatever kind it is
std::unique_ptr<KindScenario> KindFor(const Machine& machine, bool has_station = false);

/// What the scenarios of that kind of machine have of their own.
std::unique_ptr<KindScenario> ScenarioOf(const MachineKind& kind);

/// One of each, empty, gantries first.
std::vector<std::unique_ptr<KindScenario>> AllKindScenarios();

/// The kind that is meant where nobody says: a gantry, or another machine that is led
/// as one.
std::unique_ptr<KindScenario> UsualKind(const MachineKind* kind = CartesianKind());

}  // namespace caltwin

#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "calibration/loop/outcome.h"
#include "sim/machine/artefact.h"
#include "sim/machine/machine.h"
#include "sim/measure/row.h"

namespace caltwin {

/// @name As the REST interface has them
nlohmann::ordered_json ToJson(const ProcedureResult& result);
/// A touch: where, on what, from which side, and how far off [mm].
nlohmann::ordered_json ToJson(const Row& row);
/// Its name and type; what nobody knows of a real machine's is null: `at_mm` (centre of
/// its base, machine axes), `size_mm` (of the box around it, along its own axes) and
/// `turn_deg` about its vertical.
nlohmann::ordered_json ToJson(const Artefact& artefact, bool is_twin);
/// By axis: `steps_per_mm`, `backlash_mm`, `probe_deflection_mm`; `tip_radius_mm`.
nlohmann::ordered_json ToJson(const Settings& settings);
/// Throws nlohmann::json::exception where it is no such tree.
Settings SettingsOf(const nlohmann::ordered_json& tree);

/// "done", "refused", "no_trigger", ...
std::string ToString(Ending ending);

}  // namespace caltwin

#pragma once

#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include "calibration/facts/fact.h"

namespace caltwin {

/// What the numbers say by themselves, what they do not determine, and the cheapest
/// next measurement, a line each. Empty where there is nothing to say.
/// `told`: the headline; what stands there is not said again.
std::string FactsText(const Facts& facts, std::string_view told = {});

/// [{"fact": "twist", "axis": "", "height_um": 2067, "height_um_sd": 1.2, "rows": [],
/// "sigmas": 1700, "says": "..."}]; unknown uncertainties are null.
nlohmann::ordered_json FactsJson(const Facts& facts);
/// [{"what": "scale.z", "says": "..."}]
nlohmann::ordered_json NotDeterminedJson(const Facts& facts);
/// {"reason": "settings", "says": "..."}, or null.
nlohmann::ordered_json NotTheMachineJson(const Facts& facts);
/// [{"instrument": "probe", "says": "..."}]
nlohmann::ordered_json NextMeasurementJson(const Facts& facts);

}  // namespace caltwin

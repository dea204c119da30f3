#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "calibration/diagnosis/atlas.h"

namespace caltwin {

/// The atlas of a plan as a metrologist reads it.
std::string PlanAtlasText(const std::string& plan, const PlanAtlas& result);

/// `caltwin plan --json`, docs/atlas.md.
nlohmann::ordered_json PlanAtlasJson(const PlanAtlas& result);

}  // namespace caltwin

#pragma once

#include <vector>

#include <nlohmann/json.hpp>

#include "calibration/diagnosis/changes.h"

namespace caltwin {

/// `changes` of `diagnose --before --json`, docs/data-format.md: a list of objects.
nlohmann::ordered_json ChangesJson(const std::vector<Change>& changes);

}  // namespace caltwin

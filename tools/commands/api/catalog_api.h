#pragma once

#include <string>
#include <vector>

#include "tools/server/routes.h"

namespace caltwin {

/// The machines that the program came with, by name.
std::vector<std::string> ModelNames();
/// The scenarios that it came with, by name, sorted.
std::vector<std::string> ScenarioNames();

/// What there is to work with: machines with their pictures, scenarios, procedures, and
/// what a word means.
void AddCatalogTo(Routes* routes);

}  // namespace caltwin

#pragma once

#include <string>
#include <vector>

#include "tools/server/routes.h"

namespace caltwin {

/// The machines that the program came with, by name.
std::vector<std::string> ModelNames();
/// The scenarios that it came with, by name, sorted.
std::vector<std::string> ScenarioNames();

/// `?exaggerate=`, from 1 to 1e6; 1 where nothing is asked. Throws Problem 422.
double ExaggerateOf(const HttpRequest& request);
/// Throws Problem 404 where `name` is none of them.
void RequireAmong(const std::vector<std::string>& known, const std::string& name);

/// What there is to work with: machines with their pictures, scenarios, procedures, and
/// what a word means.
void AddCatalogTo(Routes* routes);

}  // namespace caltwin

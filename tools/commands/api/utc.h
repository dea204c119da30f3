#pragma once

#include <string>

namespace caltwin {

/// "2026-11-26T19:20:00Z".
std::string UtcNow();

}  // namespace caltwin

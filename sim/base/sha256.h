#pragma once

#include <string>
#include <string_view>

namespace caltwin {

/// The SHA-256 of these bytes, 64 lower-case hexadecimal digits.
std::string Sha256(std::string_view bytes);

}  // namespace caltwin

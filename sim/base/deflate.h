#pragma once

#include <string>
#include <string_view>

namespace caltwin {

/// The text in zlib's format (RFC 1950), as small as that gets.
std::string Deflated(std::string_view text);

}  // namespace caltwin

#pragma once

#include <source_location>
#include <string_view>

namespace caltwin {

/// Stops with `std::logic_error` where `condition` is false: a mistake of ours, never
/// of a user's file. Names the place. Unlike assert it also stands in Release.
void Require(bool condition,
             std::string_view what,
             std::source_location where = std::source_location::current());

}  // namespace caltwin

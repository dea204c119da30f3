#pragma once

#include <string>

namespace caltwin {

/// The kind of a file, as `caltwin import` calls it, by what stands in it (and, of
/// screw tables, by its name). "rows": measured rows themselves. Any other table is
/// "table".
std::string KindOfText(const std::string& text, const std::string& name);

}  // namespace caltwin

#pragma once

#include <set>
#include <string>

namespace caltwin {

/// The lines at which grids of heights begin that stand alone or below a title: three
/// lines or more, each of the same three numbers or more with decimal points, nearly as
/// many lines as columns, all within 20 mm. Columns that count places differ by more.
std::set<int> BareGrids(const std::string& text);

}  // namespace caltwin

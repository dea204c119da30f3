#pragma once

#include <set>
#include <string>

namespace caltwin {

/// The lines at which grids of heights begin that stand alone or below a title: three
/// lines or more, each of as many numbers, three at least, most of them no whole ones;
/// nearly as many lines as columns, all within 20 mm. Columns of places differ by more.
std::set<int> BareGrids(const std::string& text);

}  // namespace caltwin

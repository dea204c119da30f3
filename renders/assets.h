#pragma once

#include <string_view>

namespace caltwin {

/// @name Files of renders/assets, compiled in so that the binary stands alone.
std::string_view PaletteCss();  ///< Colours, light and dark; the pages have them too.
std::string_view ReportCss();   ///< How a report is laid out, on a screen and on A4.

}  // namespace caltwin

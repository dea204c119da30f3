#pragma once

#include <string_view>

namespace caltwin {

/// @name Files of renders/assets, compiled in so that the binary stands alone.
std::string_view PlotLibrary();     ///< uPlot, JavaScript.
std::string_view PlotLibraryCss();  ///< uPlot's style.
std::string_view ReportScript();    ///< Draws the plots of a report.
std::string_view ReportCss();

}  // namespace caltwin

#pragma once

#include <string>
#include <vector>

namespace caltwin {

/// One set of points in a plot; x must not decrease.
struct Series {
  std::string label{};
  std::vector<double> x{};
  std::vector<double> y{};
  bool is_line = false;  ///< Else dots.
};

/// A plot as the report's script draws it; numbers in the units that the labels name.
struct Plot {
  std::string title{};
  std::string caption{};  ///< What to look for, in a sentence.
  std::string x_label{};
  std::string y_label{};
  std::vector<Series> series{};
};

/// The plot as a figure with its data; empty where there is nothing to plot.
std::string PlotHtml(const Plot& plot);

}  // namespace caltwin

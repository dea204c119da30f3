#include "renders/plot.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "renders/html.h"

namespace caltwin {
namespace {

/// Six significant digits are finer than a pixel, and keep a report of thousands of
/// readings small.
double Rounded(double value) {
  if (value == 0 || !std::isfinite(value)) return value;
  const double scale = std::pow(10.0, 5 - std::floor(std::log10(std::abs(value))));
  return std::round(value * scale) / scale;
}

nlohmann::json Numbers(const std::vector<double>& values) {
  nlohmann::json json = nlohmann::json::array();
  for (const double value : values) json.push_back(Rounded(value));
  return json;
}

}  // namespace

std::string PlotHtml(const Plot& plot) {
  std::size_t num_points = 0;
  nlohmann::json all = nlohmann::json::array();
  for (const Series& series : plot.series) {
    num_points += series.x.size();
    all.push_back({{"label", series.label},
                   {"line", series.is_line},
                   {"x", Numbers(series.x)},
                   {"y", Numbers(series.y)}});
  }
  if (num_points == 0) return "";
  const nlohmann::json data = {
      {"x", plot.x_label}, {"y", plot.y_label}, {"series", all}};
  return fmt::format(
      "<figure class=\"plot\">\n<figcaption><strong>{}</strong> {}</figcaption>\n"
      "<div class=\"canvas\" role=\"img\" aria-label=\"{}: {} against {}, {} points in "
      "{} series\"></div>\n<script type=\"application/json\">{}</script>\n</figure>\n",
      Escaped(plot.title),
      Escaped(plot.caption),
      Escaped(plot.title),
      Escaped(plot.y_label),
      Escaped(plot.x_label),
      num_points,
      plot.series.size(),
      JsonForScript(data));
}

}  // namespace caltwin

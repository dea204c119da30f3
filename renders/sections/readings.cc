#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "renders/chart.h"
#include "renders/clusters.h"
#include "renders/html.h"
#include "renders/parts.h"
#include "renders/sections/sections.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

/// One plot series an approach direction, x ascending as the rows were measured. As
/// residuals: less the mean of the cluster, of clusters of two and more.
std::vector<ChartSeries> ByApproach(const std::vector<Cluster>& clusters,
                                    bool is_residual) {
  std::map<std::string, std::map<double, double>> points;
  for (const Cluster& cluster : clusters) {
    if (is_residual && cluster.value_mm.size() < 2) continue;
    const double middle_mm = is_residual ? cluster.mean_mm() : 0.0;
    for (std::size_t i = 0; i < cluster.number.size(); ++i) {
      points[cluster.approach][cluster.number[i]] =
          UmFromMm(cluster.value_mm[i] - middle_mm);
    }
  }
  std::vector<ChartSeries> all;
  for (const auto& [approach, values] : points) {
    ChartSeries series{.label = "moving " + approach};
    for (const auto& [number, value_um] : values) {
      series.x.push_back(number);
      series.y.push_back(value_um);
    }
    all.push_back(std::move(series));
  }
  return all;
}

std::string ClusterTable(const std::vector<Cluster>& clusters) {
  std::string rows;
  for (const Cluster& cluster : clusters) {
    rows += fmt::format(
        "<tr><th "
        "scope=\"row\"><code>{}</code></th><td>{}</td><td>{}</td>{}{}{}{}</tr>\n",
        Escaped(cluster.feature),
        Escaped(cluster.approach),
        Escaped(cluster.settings),
        NumberCell(fmt::format("{}", cluster.value_mm.size())),
        NumberCell(fmt::format("{:.2f}", UmFromMm(cluster.mean_mm()))),
        NumberCell(fmt::format("{:.2f}", UmFromMm(cluster.sd_mm()))),
        NumberCell(fmt::format("{:.2f}", UmFromMm(cluster.range_mm()))));
  }
  return fmt::format(
      "<details><summary>The {} clusters in numbers</summary>\n{}</details>\n",
      clusters.size(),
      TableHtml("Touches that ought to read alike.",
                {"feature",
                 "moving",
                 "settings",
                 "touches",
                 "mean [µm]",
                 "sd [µm]",
                 "range [µm]"},
                rows));
}

}  // namespace

std::string ReadingsSection(const RunResult& result,
                            const ReportPictures& /*pictures*/) {
  const std::vector<Cluster> clusters = ClustersOf(result.rows);
  if (clusters.empty()) return "";
  return "<div class=\"drawings\">\n" +
         FigureHtml(
             "Every touch",
             "where the machine says the surface is, minus where it lies by the "
             "drawing, along the surface's normal. Level differences between "
             "directions are backlash, pre-travel and the artefact's place.",
             ChartSvg(
                 "reading", "reported - nominal [µm]", ByApproach(clusters, false))) +
         FigureHtml("Scatter",
                    "the same touches, each minus the mean of its cluster (same point, "
                    "direction, placement and settings): what repeats is gone, noise "
                    "is left.",
                    ChartSvg("reading",
                             "reading - cluster mean [µm]",
                             ByApproach(clusters, true))) +
         "</div>\n" + ClusterTable(clusters);
}

}  // namespace caltwin

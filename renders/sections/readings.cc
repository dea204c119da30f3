#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "renders/clusters.h"
#include "renders/html.h"
#include "renders/plot.h"
#include "renders/sections/sections.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

/// One plot series an approach direction, x ascending as the rows were measured. As
/// residuals: less the mean of the cluster, of clusters of two and more.
std::vector<Series> ByApproach(const std::vector<Cluster>& clusters, bool is_residual) {
  std::map<std::string, std::map<double, double>> points;
  for (const Cluster& cluster : clusters) {
    if (is_residual && cluster.value_mm.size() < 2) continue;
    const double middle_mm = is_residual ? cluster.mean_mm() : 0.0;
    for (std::size_t i = 0; i < cluster.number.size(); ++i) {
      points[cluster.approach][cluster.number[i]] =
          UmFromMm(cluster.value_mm[i] - middle_mm);
    }
  }
  std::vector<Series> all;
  for (const auto& [approach, values] : points) {
    Series series{.label = "moving " + approach};
    for (const auto& [number, value_um] : values) {
      series.x.push_back(number);
      series.y.push_back(value_um);
    }
    all.push_back(std::move(series));
  }
  return all;
}

std::string ClusterTable(const std::vector<Cluster>& clusters) {
  std::string html = fmt::format(
      "<details><summary>The {} clusters in numbers</summary>\n"
      "<div class=\"scroll\" tabindex=\"0\"><table>\n<caption><span>Touches that ought "
      "to "
      "read alike.</span></caption>\n"
      "<thead><tr><th scope=\"col\">feature</th><th scope=\"col\">moving</th>"
      "<th scope=\"col\">settings</th><th scope=\"col\">touches</th>"
      "<th scope=\"col\">mean [µm]</th><th scope=\"col\">sd [µm]</th>"
      "<th scope=\"col\">range [µm]</th></tr></thead>\n<tbody>\n",
      clusters.size());
  for (const Cluster& cluster : clusters) {
    html += fmt::format(
        "<tr><th scope=\"row\"><code>{}</code></th><td>{}</td><td>{}</td>"
        "<td class=\"number\">{}</td><td class=\"number\">{:.2f}</td>"
        "<td class=\"number\">{:.2f}</td><td class=\"number\">{:.2f}</td></tr>\n",
        Escaped(cluster.feature),
        Escaped(cluster.approach),
        Escaped(cluster.settings),
        cluster.value_mm.size(),
        UmFromMm(cluster.mean_mm()),
        UmFromMm(cluster.sd_mm()),
        UmFromMm(cluster.range_mm()));
  }
  return html + "</tbody></table></div></details>\n";
}

}  // namespace

std::string ReadingsSection(const RunResult& result,
                            const ReportPictures& /*pictures*/) {
  const std::vector<Cluster> clusters = ClustersOf(result.rows);
  if (clusters.empty()) return "";
  const Plot values{
      .title = "Every touch",
      .caption =
          "where the machine says the surface is, minus where it lies by the "
          "drawing, along the surface's normal. Level differences between "
          "directions are backlash, pre-travel and the artefact's place.",
      .x_label = "reading",
      .y_label = "reported - nominal [µm]",
      .series = ByApproach(clusters, false)};
  const Plot scatter{
      .title = "Scatter",
      .caption =
          "the same touches, each minus the mean of its cluster (same point, "
          "direction, placement and settings): what repeats is gone, noise is "
          "left.",
      .x_label = "reading",
      .y_label = "reading - cluster mean [µm]",
      .series = ByApproach(clusters, true)};
  return "<p>Drag over a plot to look closer; a double click shows all of it "
         "again.</p>\n"
         "<div class=\"plots\">\n" +
         PlotHtml(values) + PlotHtml(scatter) + "</div>\n" + ClusterTable(clusters);
}

}  // namespace caltwin

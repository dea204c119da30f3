#include <set>
#include <string>

#include <fmt/format.h>

#include "renders/html.h"
#include "renders/sections/sections.h"

namespace caltwin {

std::string ObservabilitySection(const RunResult& result,
                                 const ReportPictures& /*pictures*/) {
  if (result.observability.empty()) return "";
  std::string html =
      "<p>Combinations that the measurements leave open: along these directions the "
      "readings do not change, so no estimator can tell.</p>\n<ul>\n";
  std::set<std::string> said;
  for (const Observability& item : result.observability) {
    if (!said.insert(item.statement).second) continue;
    html += fmt::format("<li>{}", Escaped(item.statement));
    if (!item.blind_direction.empty()) {
      html += "<br><span class=\"kind\">blind along ";
      std::string separator;
      for (const auto& [name, share] : item.blind_direction) {
        html +=
            fmt::format("{}{:+.2f} <code>{}</code>", separator, share, Escaped(name));
        separator = ", ";
      }
      html += "</span>";
    }
    html += "</li>\n";
  }
  return html + "</ul>\n";
}

}  // namespace caltwin

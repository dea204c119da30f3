#include <string>

#include <fmt/format.h>

#include "renders/display_unit.h"
#include "renders/html.h"
#include "renders/sections/sections.h"
#include "scenarios/result_text.h"

namespace caltwin {
namespace {

std::string UncertaintyRow(const ParameterResult& parameter, const Expanded& expanded) {
  const std::string shares = SharesText(parameter);
  const std::string unit =
      parameter.unit.empty() ? UnitOfName(parameter.name) : parameter.unit;
  const auto number = [](const std::string& text) {
    return fmt::format("<td class=\"number\">{}</td>", text);
  };
  return fmt::format(
      "<tr><th "
      "scope=\"row\"><code>{}</code></th><td>{}</td>{}{}{}{}{}<td>{}</td></tr>\n",
      Escaped(parameter.name),
      Escaped(UnitText(unit)),
      number(NumberText(parameter.recovered.value_or(0), expanded.U)),
      number(NumberText(expanded.u, expanded.u)),
      number(fmt::format("{:.2f}", expanded.k)),
      number(NumberText(expanded.U, expanded.U)),
      number(DofText(expanded.dof)),
      shares.empty() ? "not taken apart" : Escaped(shares));
}

}  // namespace

std::string UncertaintySection(const RunResult& result,
                               const ReportPictures& /*pictures*/) {
  std::string rows;
  for (const ParameterResult& parameter : result.parameters) {
    const auto expanded = ExpandedOf(parameter);
    if (!expanded || !parameter.recovered || !(expanded->u > 0)) continue;
    rows += UncertaintyRow(parameter, *expanded);
  }
  if (rows.empty()) return "";
  std::string pairs;
  for (const Correlations& of : AllCorrelations(result)) {
    const std::string text = CorrelationText(of);
    if (!text.empty()) pairs += fmt::format("<p>{}.</p>\n", Escaped(text));
  }
  return "<div class=\"scroll\" tabindex=\"0\"><table>\n<caption><span>Value &plusmn; "
         "U "
         "holds the truth 95&nbsp;% of the time (JCGM 100): u is the combined standard "
         "uncertainty, U = k u, dof its effective degrees of freedom, and to the right "
         "the share of its variance that each input has.</span></caption>\n<thead><tr>"
         "<th scope=\"col\">quantity</th><th scope=\"col\">unit</th>"
         "<th scope=\"col\">value</th><th scope=\"col\">u</th><th scope=\"col\">k</th>"
         "<th scope=\"col\">U</th><th scope=\"col\">dof</th>"
         "<th scope=\"col\">made of</th></tr></thead>\n<tbody>\n" +
         rows + "</tbody></table></div>\n" + pairs;
}

}  // namespace caltwin

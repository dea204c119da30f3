#include <string>

#include <fmt/format.h>

#include "renders/display_unit.h"
#include "renders/html.h"
#include "renders/parts.h"
#include "renders/sections/sections.h"
#include "scenarios/result_text.h"

namespace caltwin {
namespace {

std::string UncertaintyRow(const ParameterResult& parameter, const Expanded& expanded) {
  const std::string shares = SharesText(parameter);
  const std::string unit =
      parameter.unit.empty() ? UnitOfName(parameter.name) : parameter.unit;
  return fmt::format(
      "<tr><th "
      "scope=\"row\"><code>{}</code></th><td>{}</td>{}{}{}{}{}<td "
      "class=\"words\">{}</td></tr>\n",
      Escaped(parameter.name),
      Escaped(UnitText(unit)),
      NumberCell(NumberText(parameter.recovered.value_or(0), expanded.U)),
      NumberCell(NumberText(expanded.u, expanded.u)),
      NumberCell(fmt::format("{:.2f}", expanded.k)),
      NumberCell(NumberText(expanded.U, expanded.U)),
      NumberCell(DofText(expanded.dof)),
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
  return TableHtml(
             "Value ± U holds the truth 95 % of the time (JCGM 100): u is the combined "
             "standard uncertainty, U = k u, dof its effective degrees of freedom, and "
             "to the right the share of its variance that each input has.",
             {"quantity", "unit", "value", "u", "k", "U", "dof", "made of"},
             rows) +
         pairs;
}

}  // namespace caltwin

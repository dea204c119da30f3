#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "renders/display_unit.h"
#include "renders/html.h"
#include "renders/parts.h"
#include "renders/sections/sections.h"

namespace caltwin {
namespace {

std::string ParameterVerdict(const ParameterResult& parameter) {
  if (parameter.passed.has_value()) {
    return *parameter.passed ? BadgeHtml(Tone::kGood, "passed")
                             : BadgeHtml(Tone::kBad, "failed");
  }
  if (!parameter.identifiable) return BadgeHtml(Tone::kPlain, "cannot be told");
  return BadgeHtml(Tone::kPlain, "not checked");
}

/// Half the length of the error bar's scale: what is drawn at its ends.
double Scale(const ParameterResult& parameter) {
  const double two_sd = 2 * parameter.sd.value_or(0);
  const double error = std::abs(parameter.error.value_or(0));
  return 1.15 * std::max(parameter.tolerance.value_or(0), std::max(error, two_sd));
}

/// The error as a dot on a line with its 95 % interval, the tolerance as a band.
std::string ErrorBar(const ParameterResult& parameter) {
  const double scale = Scale(parameter);
  if (!parameter.error.has_value() || scale <= 0) return "";
  const auto x = [scale](double value) {
    return 60 + 58 * std::clamp(value / scale, -1.0, 1.0);
  };
  const double error = *parameter.error;
  const double two_sd = 2 * parameter.sd.value_or(0);
  std::string svg =
      "<svg class=\"errorbar\" viewBox=\"0 0 120 16\" aria-hidden=\"true\">";
  if (parameter.tolerance.has_value()) {
    svg += fmt::format(
        "<rect class=\"band\" x=\"{:.1f}\" y=\"3\" width=\"{:.1f}\" height=\"10\"/>",
        x(-*parameter.tolerance),
        x(*parameter.tolerance) - x(-*parameter.tolerance));
  }
  svg += "<line class=\"zero\" x1=\"60\" x2=\"60\" y1=\"1\" y2=\"15\"/>";
  svg += fmt::format(
      "<line class=\"interval\" x1=\"{:.1f}\" x2=\"{:.1f}\" y1=\"8\" y2=\"8\"/>"
      "<circle cx=\"{:.1f}\" cy=\"8\" r=\"3\"/></svg>",
      x(error - two_sd),
      x(error + two_sd),
      x(error));
  return svg;
}

/// The smallest thing that the numbers of a row should show.
double Resolution(const ParameterResult& parameter) {
  if (parameter.sd.value_or(0) > 0) return *parameter.sd;
  if (parameter.tolerance.value_or(0) > 0) return *parameter.tolerance;
  return 0;
}

/// A number with its unit where that is not the row's.
std::string Cell(const std::string& number, const std::string& unit) {
  const bool has_unit = !unit.empty() && number != "–";
  return fmt::format("<td class=\"number\">{}{}{}</td>",
                     number,
                     has_unit ? "&nbsp;" : "",
                     has_unit ? Escaped(unit) : "");
}

std::string ValueText(std::optional<double> value, double resolution) {
  return NumberText(value.value_or(std::nan("")), resolution);
}

std::string ParameterRow(const ParameterResult& parameter) {
  const std::string unit =
      parameter.unit.empty() ? UnitOfName(parameter.name) : parameter.unit;
  const ErrorUnit small = ErrorUnitOf(unit);
  const std::string small_name = small.name == UnitText(unit) ? "" : small.name;
  const double resolution = Resolution(parameter);
  const double factor = small.per_unit;
  const double nan = std::nan("");
  std::string row = fmt::format(
      "<tr><th scope=\"row\"><code>{}</code><span class=\"kind\">{}</span></th>"
      "<td>{}</td><td>{}</td>",
      Escaped(parameter.name),
      parameter.is_setting ? "setting" : "estimate",
      ParameterVerdict(parameter),
      Escaped(UnitText(unit)));
  row += Cell(NumberText(parameter.injected, resolution), "");
  row += Cell(ValueText(parameter.recovered, resolution), "");
  row += Cell(SignedText(parameter.error.value_or(nan) * factor, resolution * factor),
              small_name);
  row += Cell(NumberText(parameter.sd.value_or(nan) * factor, resolution * factor),
              small_name);
  const double tolerance = parameter.tolerance.value_or(nan) * factor;
  row += Cell(NumberText(tolerance, tolerance), small_name);
  row += fmt::format("<td>{}</td></tr>\n", ErrorBar(parameter));
  return row;
}

std::string ParameterTable(const RunResult& result) {
  std::string rows;
  for (const ParameterResult& parameter : result.parameters) {
    rows += ParameterRow(parameter);
  }
  return TableHtml(
      "What the machine was given, and what the calibration found. The bar shows the "
      "error (dot), its 95 % interval (line) and the tolerance (band).",
      {"quantity",
       "verdict",
       "unit",
       "injected",
       "recovered",
       "error",
       "uncertainty (1 sd)",
       "tolerance",
       "error in its tolerance"},
      rows);
}

std::string CheckTable(const RunResult& result) {
  std::string rows;
  for (const CheckResult& check : result.checks) {
    rows += fmt::format(
        "<tr><th scope=\"row\"><code>{}</code></th><td class=\"words\">{}</td><td "
        "class=\"words\">{}</td><td>{}</td></tr>\n",
        Escaped(check.name),
        Escaped(check.expected),
        Escaped(check.found),
        check.passed ? BadgeHtml(Tone::kGood, "passed")
                     : BadgeHtml(Tone::kBad, "failed"));
  }
  return TableHtml("What else the scenario expects.",
                   {"check", "expected", "found", "verdict"},
                   rows);
}

}  // namespace

std::string VerdictSection(const RunResult& result,
                           const ReportPictures& /*pictures*/) {
  return ParameterTable(result) + CheckTable(result);
}

}  // namespace caltwin

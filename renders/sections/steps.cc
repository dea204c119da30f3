#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "calibration/loop/outcome.h"
#include "renders/display_unit.h"
#include "renders/html.h"
#include "renders/parts.h"
#include "renders/sections/sections.h"

namespace caltwin {
namespace {

Tone ToneOf(Verdict verdict) {
  switch (verdict) {
    case Verdict::kApplied:
      return Tone::kGood;
    case Verdict::kMeasured:
      return Tone::kPlain;
    case Verdict::kRefused:
      return Tone::kWarn;
    case Verdict::kRolledBack:
      return Tone::kBad;
  }
  return Tone::kPlain;
}

std::string VerdictWord(Verdict verdict) {
  return verdict == Verdict::kRolledBack ? "rolled back" : ToString(verdict);
}

/// Enough digits to see a small change, and never fewer than the unit deserves; 0:
/// whatever the number needs.
double Resolution(const Step& step, std::string_view unit) {
  const double usual = unit == "1/mm" ? 0.01 : unit == "mm" ? 0.001 : 0;
  const double change = std::abs(step.after - step.before);
  return change > 0 ? std::clamp(change, usual / 100, usual) : usual;
}

std::string StepRow(const Step& step, std::size_t number) {
  const std::string unit = step.unit.empty() ? UnitOfName(step.name) : step.unit;
  const double resolution = Resolution(step, unit);
  const std::string variant =
      step.variant.empty()
          ? ""
          : fmt::format(" <span class=\"kind\">{}</span>", Escaped(step.variant));
  return fmt::format(
      "<tr><td class=\"number\">{}</td><td><code>{}</code>{}</td>"
      "<td class=\"number\">{}</td><td><code>{}</code></td>"
      "<td class=\"number\">{}</td><td class=\"number\">{}</td><td>{}</td>"
      "<td>{}</td><td class=\"words\">{}</td></tr>\n",
      number,
      Escaped(step.procedure),
      variant,
      step.iteration,
      Escaped(step.name),
      step.has_before ? NumberText(step.before, resolution) : "",
      NumberText(step.after, resolution),
      Escaped(UnitText(unit)),
      BadgeHtml(ToneOf(step.verdict), VerdictWord(step.verdict)),
      Escaped(step.message));
}

}  // namespace

std::string StepsSection(const RunResult& result, const ReportPictures& /*pictures*/) {
  if (result.steps.empty()) return "<p>Nothing was applied or measured.</p>\n";
  std::string rows;
  std::size_t number = 0;
  for (const Step& step : result.steps) rows += StepRow(step, ++number);
  return TableHtml("What the procedures made of each quantity.",
                   {"step",
                    "procedure",
                    "pass",
                    "quantity",
                    "before",
                    "after",
                    "unit",
                    "verdict",
                    "message"},
                   rows);
}

}  // namespace caltwin

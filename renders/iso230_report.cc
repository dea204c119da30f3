#include "renders/iso230_report.h"

#include <cstddef>
#include <filesystem>
#include <limits>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "renders/chart.h"
#include "renders/html.h"
#include "renders/parts.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

double Um(const std::optional<double>& value_mm) {
  return value_mm ? UmFromMm(*value_mm) : kNone;
}

std::string LengthOrNone(const std::optional<double>& value_mm) {
  return value_mm ? LengthText(*value_mm) : "not determined";
}

std::string VerdictSentence(const Iso230Sheet& sheet) {
  const Iso230Symbols& symbols = sheet.symbols;
  const std::string axis(1, CapitalLetter(sheet.axis));
  if (symbols.a) {
    return fmt::format(
        "{} positions within A = {} over both directions; repeatability R = {}, "
        "reversal B = {}.",
        axis,
        LengthText(*symbols.a),
        LengthOrNone(symbols.r),
        LengthOrNone(symbols.b));
  }
  const bool is_forward = symbols.a_fwd.has_value();
  const std::optional<double> one = is_forward ? symbols.a_fwd : symbols.a_bwd;
  if (!one) {
    return fmt::format(
        "These readings do not determine how accurately {} positions: each place needs "
        "two runs or more.",
        axis);
  }
  return fmt::format(
      "{} positions within {} in one direction ({}); the other was not "
      "measured.",
      axis,
      LengthText(*one),
      is_forward ? "forward" : "backward");
}

// The mean of one direction, and two standard deviations to either side.
void AddDirection(const Iso230Sheet& sheet,
                  std::optional<double> Iso230Position::*mean,
                  std::optional<double> Iso230Position::*spread,
                  const std::string& label,
                  std::vector<ChartSeries>* all) {
  ChartSeries points{.label = label, .is_line = true};
  ChartSeries low{.is_line = true}, high{.is_line = true};
  for (const Iso230Position& position : sheet.positions) {
    const double mean_um = Um(position.*mean);
    const double two_s_um = 2 * Um(position.*spread);
    points.x.push_back(position.target_mm);
    points.y.push_back(mean_um);
    low.y.push_back(mean_um - two_s_um);
    high.y.push_back(mean_um + two_s_um);
  }
  low.x = high.x = points.x;
  low.label = fmt::format("{} ± 2 s", label);
  all->insert(all->end(), {points, low, high});
}

std::string Drawing(const Iso230Sheet& sheet) {
  std::vector<ChartSeries> all;
  AddDirection(
      sheet, &Iso230Position::mean_fwd_mm, &Iso230Position::s_fwd_mm, "forward", &all);
  AddDirection(
      sheet, &Iso230Position::mean_bwd_mm, &Iso230Position::s_bwd_mm, "backward", &all);
  const std::vector<Ink> inks = {
      Ink::kBefore, Ink::kFifth, Ink::kFifth, Ink::kAfter, Ink::kThird, Ink::kThird};
  std::vector<const std::vector<double>*> x, y;
  for (const ChartSeries& one : all) {
    x.push_back(&one.x);
    y.push_back(&one.y);
  }
  const ChartRange across = RangeOf(x, 0.02), up = RangeOf(y, 0.08);
  Chart chart({.x_label = "target [mm]",
               .y_label = "error [µm]",
               .x_min = across.min,
               .x_max = across.max,
               .y_min = up.min,
               .y_max = up.max});
  for (std::size_t i = 0; i < all.size(); ++i) {
    const bool is_upper_limit = i % 3 == 2;
    chart.Line(all[i].x, all[i].y, inks[i], is_upper_limit ? "" : all[i].label);
    if (i % 3 == 0) chart.Points(all[i].x, all[i].y, inks[i], "");
  }
  return chart.Svg();
}

std::string Number(const std::optional<double>& value_mm) {
  return NumberCell(value_mm ? fmt::format("{:.2f}", UmFromMm(*value_mm)) : "–");
}

std::string SymbolTable(const Iso230Sheet& sheet) {
  std::string rows;
  for (const NamedSymbol& symbol : AllIso230Symbols()) {
    rows += fmt::format("<tr><th scope=\"row\">{}</th><td>{}</td>{}{}</tr>\n",
                        Escaped(symbol.name),
                        Escaped(symbol.words),
                        Number(sheet.symbols.*symbol.value),
                        Number(sheet.expanded_u.*symbol.value));
  }
  return TableHtml(
      "The symbols of ISO 230-2:2014. U is the expanded uncertainty of the "
      "measurement, k = 2; a dash: these readings do not determine it.",
      {"symbol", "what it is", "value [µm]", "U [µm]"},
      rows);
}

std::string PositionTable(const Iso230Sheet& sheet) {
  std::string rows;
  for (const Iso230Position& position : sheet.positions) {
    rows += fmt::format("<tr>{}{}{}{}{}{}</tr>\n",
                        NumberCell(fmt::format("{:.4f}", position.target_mm)),
                        Number(position.mean_fwd_mm),
                        Number(position.mean_bwd_mm),
                        Number(position.s_fwd_mm),
                        Number(position.s_bwd_mm),
                        Number(position.b_mm));
  }
  return TableHtml(
      "Each place; s is the standard deviation of its runs, B the "
      "reversal.",
      {"target [mm]",
       "mean forward [µm]",
       "mean backward [µm]",
       "s forward [µm]",
       "s backward [µm]",
       "B [µm]"},
      rows);
}

}  // namespace

Document Iso230Document(const Iso230Sheet& sheet, const Iso230Notes& notes) {
  const std::string name = std::filesystem::path(notes.data).filename().string();
  const std::string drawing = Drawing(sheet);
  return {
      .kind = "ISO 230-2 sheet",
      .name = fmt::format("{}, axis {}", name, CapitalLetter(sheet.axis)),
      .about = fmt::format("Campaign {}.", sheet.campaign),
      .tone = Tone::kPlain,
      .verdict = VerdictSentence(sheet),
      .tiles = {{"accuracy A", LengthOrNone(sheet.symbols.a)},
                {"repeatability R", LengthOrNone(sheet.symbols.r)},
                {"reversal B", LengthOrNone(sheet.symbols.b)},
                {"places", fmt::format("{}", sheet.positions.size())}},
      .sections =
          {{"errors",
            "Errors over the travel",
            FigureHtml(
                "The mean error of each place",
                "come upon in either direction, and two standard deviations of its "
                "runs. What lies between the two lines is the reversal.",
                drawing)},
           {"symbols", "The sheet", SymbolTable(sheet)},
           {"places", "Place by place", PositionTable(sheet)},
           {"remarks", "What a reader must know", ListHtml(sheet.remarks)},
           {"text",
            "As printed, with conditions and what U is made of",
            fmt::format("<pre>{}</pre>\n", Escaped(notes.text))},
           {"provenance",
            "How to make this report again",
            fmt::format("<p>caltwin {}, rows of {}.</p>\n<pre><code>{}</code></pre>\n",
                        CALTWIN_VERSION,
                        Escaped(notes.data),
                        Escaped(notes.command))}},
      .drawings = {{"errors", drawing}}};
}

}  // namespace caltwin

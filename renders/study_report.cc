#include "renders/study_report.h"

#include <algorithm>
#include <cstddef>
#include <optional>

#include <fmt/format.h>

#include "renders/document.h"
#include "renders/html.h"
#include "renders/parts.h"
#include "renders/study_pictures.h"
#include "scenarios/result_text.h"
#include "scenarios/study/best_readings.h"
#include "sim/base/text_file.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

std::string Validated(const ParameterSummary& parameter) {
  const Validation& gum = parameter.gum;
  if (!gum.is_settled) return "too few trials";
  return gum.holds() ? "holds" : "does not hold";
}

std::string RangeText(double low, double high, double resolution) {
  return fmt::format(
      "{} to {}", SignedText(low, resolution), SignedText(high, resolution));
}

std::string CoverageTable(const CaseSummary& summary) {
  std::string rows, not_told;
  for (const ParameterSummary& one : summary.parameters) {
    if (one.coverage95.cases == 0) {
      not_told += (not_told.empty() ? "" : ", ") + one.name;
      continue;
    }
    const Rate& coverage = one.coverage95;
    rows += fmt::format(
        "<tr><th "
        "scope=\"row\"><code>{}</code></th><td>{}</td>{}{}{}{}{}{}{}{}{}{}{}</tr>\n",
        Escaped(one.name),
        Escaped(one.unit),
        NumberCell(fmt::format("{}", one.identified.hits)),
        NumberCell(SignedText(one.error.mean, one.error.sd / 10)),
        NumberCell(NumberText(one.error.sd, one.error.sd / 10)),
        NumberCell(RangeText(one.error.q025, one.error.q975, one.error.sd / 10)),
        NumberCell(RangeText(
            one.error.shortest_low, one.error.shortest_high, one.error.sd / 10)),
        NumberCell(NumberText(one.stated.U, one.stated.U)),
        NumberCell(fmt::format("{:.2f}", one.stated.k)),
        NumberCell(DofText(one.stated.dof)),
        NumberCell(fmt::format("{:.3f}", one.rms_over_sd)),
        NumberCell(fmt::format("{:.1f} ({:.1f} to {:.1f})",
                               PercentFromFraction(coverage.rate),
                               PercentFromFraction(coverage.low),
                               PercentFromFraction(coverage.high))),
        NumberCell(Validated(one)));
  }
  std::string html = TableHtml(
      "U = k u: the 95 % interval as the machines state it, root of their mean square; "
      "dof: effective degrees of freedom of u. rms/sd: root mean square error over the "
      "stated standard deviation, 1 where "
      "it is honest. JCGM 101, 8: whether the stated interval is the one the "
      "trials show, to one digit of u. What machines so drawn scatter by is the "
      "procedure's error on such machines, not the uncertainty of one result.",
      {"quantity",
       "unit",
       "told",
       "mean error",
       "sd of errors",
       "95 % of errors",
       "shortest 95 %",
       "U",
       "k",
       "dof",
       "rms/sd",
       "coverage of 95 % [%]",
       "JCGM 101, 8"},
      rows);
  if (!not_told.empty()) {
    html += fmt::format(
        "<p>Varied or looked at, but not told or without a stated "
        "uncertainty: <code>{}</code>.</p>\n",
        Escaped(not_told));
  }
  return html;
}

std::string BudgetTable(const std::vector<Budget>& budgets) {
  std::string rows;
  for (const Budget& budget : budgets) {
    for (const BudgetLine& line : budget.lines) {
      rows += fmt::format(
          "<tr><th scope=\"row\"><code>{}</code></th><td>{}</td>{}{}{}{}</tr>\n",
          Escaped(budget.name),
          line.input.empty() ? "readings and all else"
                             : fmt::format("<code>{}</code>", Escaped(line.input)),
          NumberCell(line.input.empty() ? "" : fmt::format("{:.3g}", line.u)),
          NumberCell(line.input.empty() ? "" : fmt::format("{:+.3g}", line.c)),
          NumberCell(fmt::format("{:.3g} {}", line.contribution, budget.unit)),
          NumberCell(fmt::format("{:.1f} %", PercentFromFraction(line.share))));
    }
  }
  return TableHtml(
      "Regression of errors on what was varied; what chance could make is "
      "counted to the readings.",
      {"error of", "input", "u", "c", "contribution", "share of variance"},
      rows);
}

std::string PairsTable(const CaseSummary& summary) {
  constexpr std::size_t kMost = 10;
  std::string rows;
  for (const CorrelatedPair& pair : PairsBeyondChance(summary, kMost)) {
    rows += fmt::format(
        "<tr><th scope=\"row\"><code>{}</code></th><td><code>{}</code></td>{}</tr>\n",
        Escaped(pair.first),
        Escaped(pair.second),
        NumberCell(fmt::format("{:+.2f}", pair.r)));
  }
  return TableHtml(
      "Correlation of errors over the machines, where it is 0.3 or more and chance "
      "does "
      "not make it. What is computed from two of them needs it (JCGM 100, 5.2).",
      {"error of", "goes with", "r"},
      rows);
}

std::string WorstList(const Study& study, const CaseSummary& summary) {
  if (summary.worst.empty()) return "";
  std::string html =
      "<p>The command runs that machine alone and shows all of it.</p>\n<ol>\n";
  for (const std::int64_t trial : summary.worst) {
    html += fmt::format("<li>trial {}: <code>{}</code></li>\n",
                        trial,
                        Escaped(ReplayCommand(study, trial)));
  }
  return html + "</ol>\n";
}

std::string Histograms(const CaseSummary& summary) {
  std::string html;
  for (const ParameterSummary& one : summary.parameters) {
    html += FigureHtml(
        one.name, fmt::format("{} machines.", one.error.count), HistogramSvg(one));
  }
  if (html.empty()) return "";
  return "<p>Columns: errors of the machines. Curve and dashed lines: the spread and "
         "the "
         "95 % interval that the estimates state.</p>\n<div class=\"drawings\">\n" +
         html + "</div>\n";
}

// The sections of one contender; their ids carry its number where there are several.
std::vector<DocumentSection> SectionsOf(const Study& study,
                                        const CaseSummary& summary,
                                        const std::vector<Budget>& budgets,
                                        std::size_t number) {
  const auto section =
      [&](const std::string& id, const std::string& title, const std::string& html) {
        return number == 0 ? DocumentSection{id, title, html}
                           : DocumentSection{fmt::format("{}-{}", id, number),
                                             fmt::format("{}: {}", summary.name, title),
                                             html};
      };
  return {section("coverage",
                  "How often the truth was inside",
                  FigureHtml("Coverage of intervals of 95 %",
                             "A dot and its own 95 % interval; the band is 93 to 97 %.",
                             CoverageSvg(summary.parameters)) +
                      CoverageTable(summary)),
          section("errors", "Errors", Histograms(summary)),
          section("budget", "Where errors come from", BudgetTable(budgets)),
          section("pairs", "Errors that go together", PairsTable(summary)),
          section("worst", "Worst machines", WorstList(study, summary))};
}

// "in 94.0 to 96.1 % of the machines the stated 95 % interval held the truth".
std::string CoverageText(const CaseSummary& summary) {
  std::optional<double> least, most;
  for (const ParameterSummary& one : summary.parameters) {
    if (one.coverage95.cases == 0) continue;
    const double rate = one.coverage95.rate;
    least = std::min(rate, least.value_or(rate));
    most = std::max(rate, most.value_or(rate));
  }
  if (!least) return "no uncertainty was stated that could be checked";
  const std::string low = fmt::format("{:.1f}", PercentFromFraction(*least));
  const std::string high = fmt::format("{:.1f}", PercentFromFraction(*most));
  return fmt::format("the stated 95 % intervals held the truth in {} % of the machines",
                     low == high ? low : fmt::format("{} to {}", low, high));
}

std::string VerdictText(const CaseSummary& summary) {
  std::string states;
  for (const auto& [status, count] : summary.status) {
    states += fmt::format("{}{} {}", states.empty() ? "" : ", ", count, status);
  }
  return fmt::format("{}: {}. {:.0f} touches and {} on the machine (medians).",
                     states,
                     CoverageText(summary),
                     summary.touches.median,
                     DurationText(summary.machine_time_s.median));
}

Document DocumentOf(const Study& study, const StudyFindings& findings) {
  const auto& cases = findings.summary.cases;
  const bool is_one = cases.size() == 1;
  Document document{.kind = "study",
                    .name = study.file.stem().string(),
                    .about = study.about,
                    .tiles = {{"machines", fmt::format("{}", findings.summary.trials)},
                              {"fidelity", study.FidelityWord()},
                              {"seed", fmt::format("{}", study.seed)},
                              {"caltwin", CALTWIN_VERSION}}};
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const std::string verdict = VerdictText(cases[i]);
    if (is_one) {
      document.verdict = fmt::format("{}: {}", cases[i].name, verdict);
    } else {
      document.remarks.push_back(fmt::format("{}: {}", cases[i].name, verdict));
    }
    const auto sections = SectionsOf(
        study,
        cases[i],
        i < findings.budgets.size() ? findings.budgets[i] : std::vector<Budget>{},
        is_one ? 0 : i + 1);
    document.sections.insert(document.sections.end(), sections.begin(), sections.end());
    const std::string prefix = is_one ? "" : cases[i].name + "_";
    document.drawings.push_back(
        {prefix + "coverage", CoverageSvg(cases[i].parameters)});
    for (const ParameterSummary& one : cases[i].parameters) {
      document.drawings.push_back({prefix + "errors_" + one.name, HistogramSvg(one)});
    }
  }
  if (cases.size() > 1) {
    document.verdict = fmt::format("{} contenders on the same machines", cases.size());
  }
  document.remarks.insert(
      document.remarks.end(), study.notes.begin(), study.notes.end());
  const auto words = [](const std::string& text) {
    return fmt::format("<pre class=\"words\">{}</pre>\n", Escaped(text));
  };
  if (study.plan) {
    document.sections.push_back({"plan",
                                 "What the plan determines",
                                 words(WorthText(*study.plan, WorthOf(*study.plan)))});
  }
  if (!findings.remarks.empty()) {
    document.sections.push_back({"remarks", "Remarks", words(findings.remarks)});
  }
  document.sections.push_back(
      {"study", "The study, as it was read", words(study.verbatim)});
  return document;
}

}  // namespace

std::string StudyReportHtml(const Study& study, const StudyFindings& findings) {
  return DocumentHtml(DocumentOf(study, findings));
}

void WriteStudyReport(const Study& study,
                      const StudyFindings& findings,
                      const std::filesystem::path& folder) {
  WriteDocument(DocumentOf(study, findings), folder);
}

}  // namespace caltwin

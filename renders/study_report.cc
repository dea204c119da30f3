#include "renders/study_report.h"

#include <fmt/format.h>

#include "renders/assets.h"
#include "renders/html.h"
#include "renders/study_pictures.h"
#include "scenarios/result_text.h"
#include "scenarios/study/best_readings.h"
#include "sim/base/text_file.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr std::string_view kStyle = R"(
.histograms { display: grid; grid-template-columns: repeat(auto-fill, minmax(20rem, 1fr)); gap: 1rem; }
figure { margin: 0; } figure svg { display: block; width: 100%; height: auto; border: 1px solid var(--line); border-radius: 8px; }
.coverage { max-width: 44rem; }
)";

std::string Cell(const std::string& text) {
  return fmt::format("<td class=\"number\">{}</td>", Escaped(text));
}

std::string Table(const std::string& caption,
                  const std::vector<std::string>& headings,
                  const std::string& rows) {
  std::string head;
  for (const std::string& heading : headings) {
    head += fmt::format("<th scope=\"col\">{}</th>", Escaped(heading));
  }
  return fmt::format(
      "<div class=\"scroll\" tabindex=\"0\"><table>\n<caption><span>{}</span></caption>"
      "\n<thead><tr>{}</tr></thead>\n<tbody>\n{}</tbody></table></div>\n",
      Escaped(caption),
      head,
      rows);
}

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
        Cell(fmt::format("{}", one.identified.hits)),
        Cell(SignedText(one.error.mean, one.error.sd / 10)),
        Cell(NumberText(one.error.sd, one.error.sd / 10)),
        Cell(RangeText(one.error.q025, one.error.q975, one.error.sd / 10)),
        Cell(RangeText(
            one.error.shortest_low, one.error.shortest_high, one.error.sd / 10)),
        Cell(NumberText(one.stated.U, one.stated.U)),
        Cell(fmt::format("{:.2f}", one.stated.k)),
        Cell(DofText(one.stated.dof)),
        Cell(fmt::format("{:.3f}", one.rms_over_sd)),
        Cell(fmt::format("{:.1f} ({:.1f} to {:.1f})",
                         PercentFromFraction(coverage.rate),
                         PercentFromFraction(coverage.low),
                         PercentFromFraction(coverage.high))),
        Cell(Validated(one)));
  }
  std::string html = Table(
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
          Cell(line.input.empty() ? "" : fmt::format("{:.3g}", line.u)),
          Cell(line.input.empty() ? "" : fmt::format("{:+.3g}", line.c)),
          Cell(fmt::format("{:.3g} {}", line.contribution, budget.unit)),
          Cell(fmt::format("{:.1f} %", PercentFromFraction(line.share))));
    }
  }
  if (rows.empty()) return "";
  return Table(
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
        Cell(fmt::format("{:+.2f}", pair.r)));
  }
  if (rows.empty()) return "";
  return Table(
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

std::string Section(const std::string& title, const std::string& html) {
  if (html.empty()) return "";
  return fmt::format("<section>\n<h2>{}</h2>\n{}</section>\n", Escaped(title), html);
}

std::string CaseHtml(const Study& study,
                     const CaseSummary& summary,
                     const std::vector<Budget>& budgets) {
  std::string states;
  for (const auto& [status, count] : summary.status) {
    states += fmt::format("{}{} {}", states.empty() ? "" : ", ", count, status);
  }
  std::string histograms;
  for (const ParameterSummary& one : summary.parameters) {
    const std::string svg = HistogramSvg(one);
    if (!svg.empty()) histograms += "<figure>" + svg + "</figure>\n";
  }
  if (!histograms.empty()) {
    histograms =
        "<p>Bars: errors of the machines. Curve and dashed lines: the spread and the "
        "95 % interval that the estimates state.</p>\n<div class=\"histograms\">\n" +
        histograms + "</div>\n";
  }
  const std::string coverage = CoverageSvg(summary.parameters);
  return fmt::format(
             "<h1>{}</h1>\n<p>{}; {:.0f} touches and {} on the machine "
             "(medians).</p>\n",
             Escaped(summary.name),
             Escaped(states),
             summary.touches.median,
             DurationText(summary.machine_time_s.median)) +
         Section("How often the truth was inside",
                 (coverage.empty()
                      ? ""
                      : "<figure class=\"coverage\">" + coverage + "</figure>\n") +
                     CoverageTable(summary)) +
         Section("Errors", histograms) +
         Section("Where errors come from", BudgetTable(budgets)) +
         Section("Errors that go together", PairsTable(summary)) +
         Section("Worst machines", WorstList(study, summary));
}

std::string HeaderHtml(const Study& study, const StudySummary& summary) {
  const auto tile = [](const std::string& value, const char* label) {
    return fmt::format("<div><dt>{}</dt><dd>{}</dd></div>\n", label, Escaped(value));
  };
  std::string notes;
  for (const std::string& note : study.notes) {
    notes += fmt::format("<p class=\"about\">{}</p>\n", Escaped(note));
  }
  return fmt::format(
      "<header>\n<p class=\"brand\">caltwin</p>\n<h1>{}</h1>\n<p "
      "class=\"about\">{}</p>\n{}"
      "<dl class=\"tiles\">\n{}{}{}{}</dl>\n</header>\n",
      Escaped(study.file.stem().string()),
      Escaped(study.about),
      notes,
      tile(fmt::format("{}", summary.trials), "machines"),
      tile(study.FidelityWord(), "fidelity"),
      tile(fmt::format("{}", study.seed), "seed"),
      tile(CALTWIN_VERSION, "caltwin"));
}

}  // namespace

std::string StudyReportHtml(const Study& study, const StudyFindings& findings) {
  std::string body = HeaderHtml(study, findings.summary) + "<main>\n";
  for (std::size_t i = 0; i < findings.summary.cases.size(); ++i) {
    body += CaseHtml(
        study,
        findings.summary.cases[i],
        i < findings.budgets.size() ? findings.budgets[i] : std::vector<Budget>{});
  }
  if (study.plan) {
    const std::string told = WorthText(*study.plan, WorthOf(*study.plan));
    body += Section(
        "What the plan tells",
        fmt::format("<pre style=\"white-space: pre-wrap\">{}</pre>\n", Escaped(told)));
  }
  if (!findings.remarks.empty()) {
    body +=
        Section("Remarks", fmt::format("<pre>{}</pre>\n", Escaped(findings.remarks)));
  }
  body += Section("The study, as it was read",
                  fmt::format("<pre>{}</pre>\n", Escaped(study.verbatim)));
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"color-scheme\" content=\"light dark\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; "
      "img-src data:; style-src 'unsafe-inline'\">\n"
      "<title>{} - "
      "caltwin</title>\n<style>\n{}\n{}</style>\n</head>\n<body>\n{}</main>\n"
      "</body>\n</html>\n",
      Escaped(study.file.stem().string()),
      ReportCss(),
      kStyle,
      body);
}

void WriteStudyReport(const Study& study,
                      const StudyFindings& findings,
                      const std::filesystem::path& folder) {
  for (const CaseSummary& summary : findings.summary.cases) {
    const std::string prefix =
        findings.summary.cases.size() > 1 ? summary.name + " " : "";
    const auto write = [&](const std::string& name, const std::string& svg) {
      if (svg.empty()) return;
      std::string file = prefix + name + ".svg";
      for (char& c : file) {
        if (c == '/' || c == ':' || c == ' ') c = '_';
      }
      WriteTextFile(folder / file, svg);
    };
    write("coverage", CoverageSvg(summary.parameters));
    for (const ParameterSummary& one : summary.parameters) {
      write("errors_" + one.name, HistogramSvg(one));
    }
  }
  WriteTextFile(folder / "index.html", StudyReportHtml(study, findings));
}

}  // namespace caltwin

#include "renders/diagnosis_report.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "calibration/diagnosis/diagnosis_text.h"
#include "calibration/diagnosis/diagnosis_words.h"
#include "calibration/diagnosis/pictures_json.h"
#include "renders/assets.h"
#include "renders/diagnosis_pictures.h"
#include "renders/html.h"
#include "sim/base/text_file.h"
#include "sim/base/units.h"
#include "sim/effects/catalog.h"

namespace caltwin {
namespace {

// Drawings carry light colours; the page's own, dark scheme included, go before them.
constexpr std::string_view kStyle = R"(
.drawing { margin: 0 0 1.6rem; padding: .9rem 1rem .6rem; background: var(--card); border: 1px solid var(--line); border-radius: 8px; max-width: 62rem; }
.drawing figcaption p { max-width: none; margin: .2rem 0 .4rem; }
.drawing svg { display: block; width: 100%; height: auto; margin-top: .5rem; }
.drawing pre { margin: .6rem 0 .3rem; padding: .4rem .7rem; font-size: .8rem; }
.drawn .page { fill: var(--card); }
.drawn .fill-before { fill: var(--series-1); } .drawn .stroke-before { stroke: var(--series-1); }
.drawn .fill-after { fill: var(--series-2); } .drawn .stroke-after { stroke: var(--series-2); }
.drawn .fill-third { fill: var(--series-3); } .drawn .stroke-third { stroke: var(--series-3); }
.drawn .fill-text { fill: var(--ink); } .drawn .stroke-text { stroke: var(--ink); }
.drawn .fill-dim { fill: var(--dim); } .drawn .stroke-dim { stroke: var(--dim); }
.drawn .stroke-grid { stroke: var(--line); }
.drawn .band { fill: var(--good-page); } .drawn .shade { fill: var(--dim-page); }
.cause dt { color: var(--dim); font-size: .85rem; margin-top: .7rem; }
.cause dd { margin: 0; max-width: 50rem; }
.verdict-text { white-space: pre-wrap; }
)";

std::string Section(std::string_view id,
                    std::string_view title,
                    std::string_view html) {
  if (html.empty()) return "";
  return fmt::format(
      "<section id=\"{0}\" aria-labelledby=\"{0}-title\">\n"
      "<h2 id=\"{0}-title\">{1}</h2>\n{2}</section>\n",
      id,
      Escaped(title),
      html);
}

std::string Drawing(const DiagnosisPicture& picture,
                    const DiagnosisReportNotes& notes) {
  if (picture.svg.empty()) return "";
  return fmt::format(
      "<figure class=\"drawing\">\n<figcaption><strong>{}</strong><p>{}</p>"
      "</figcaption>\n{}<pre><code>{} --report {}</code></pre>\n"
      "<p class=\"kind\">{}/{}.svg</p>\n</figure>\n",
      Escaped(picture.title),
      Escaped(picture.caption),
      picture.svg,
      Escaped(notes.command),
      Escaped(notes.folder),
      Escaped(notes.folder),
      picture.name);
}

std::string BadgeOf(DiagnosisVerdict verdict) {
  const std::string_view kind = verdict == DiagnosisVerdict::kNone    ? "dim"
                                : verdict == DiagnosisVerdict::kNamed ? "good"
                                                                      : "warn";
  const std::string_view word = verdict == DiagnosisVerdict::kNone        ? "none"
                                : verdict == DiagnosisVerdict::kNamed     ? "named"
                                : verdict == DiagnosisVerdict::kAmbiguous ? "ambiguous"
                                                                          : "unknown";
  return fmt::format("<span class=\"badge {}\">{}</span>", kind, word);
}

std::string Tile(std::string_view value, std::string_view label) {
  return fmt::format(
      "<div><dt>{}</dt><dd>{}</dd></div>\n", Escaped(label), Escaped(value));
}

std::string Header(const Diagnosis& diagnosis, const DiagnosisReportNotes& notes) {
  const GainFigures& gain = diagnosis.gain;
  const std::string name = std::filesystem::path(notes.data).filename().string();
  std::string tiles = Tile(fmt::format("{}", diagnosis.findings.size()), "findings");
  tiles += Tile(LengthText(gain.blocks.before_mm), "rms before, rows left out");
  tiles += Tile(LengthText(gain.blocks.after_mm), "rms after, rows left out");
  tiles += Tile(LengthText(gain.noise_floor_mm), "noise floor");
  tiles += Tile(fmt::format("{}", diagnosis.residual_before_mm.size()), "readings");
  return fmt::format(
      "<header>\n<p class=\"brand\">caltwin</p>\n<h1>{} {}</h1>\n"
      "<p class=\"about\">What these rows say the model gets wrong, and why.</p>\n"
      "<dl class=\"tiles\">\n{}</dl>\n</header>\n",
      Escaped(name),
      BadgeOf(diagnosis.verdict),
      tiles);
}

std::string Item(std::string_view term, std::string_view html) {
  if (html.empty()) return "";
  return fmt::format("<dt>{}</dt><dd>{}</dd>\n", term, html);
}

std::string ValuesHtml(const Finding& finding) {
  std::string html = "<ul>\n";
  const auto effect = FindEffect(finding.cause);
  for (const FindingParameter& one : finding.parameters) {
    std::string_view unit;
    if (effect) {
      for (const Parameter& declared : EffectAt(*effect).parameters) {
        if (declared.name == one.name) unit = declared.unit;
      }
    }
    html += fmt::format("<li><code>{}</code> {}</li>\n",
                        Escaped(one.name),
                        Escaped(WithSd(one.value, one.sd, unit)));
  }
  html += fmt::format(
      "<li>near-peak in these rows {:.3g} µm; share {:.1f} %; probability {:.4f}; log "
      "odds {:.1f}</li>\n",
      finding.peak_um,
      PercentFromFraction(finding.share),
      finding.probability,
      finding.log_odds);
  return html + "</ul>\n";
}

std::string RivalsHtml(const Finding& finding) {
  std::string html;
  for (std::size_t i = 1; i < finding.candidates.size(); ++i) {
    const FindingCandidate& rival = finding.candidates[i];
    html += fmt::format("<li>{}: probability {:.4f}{}</li>\n",
                        Escaped(NameInWords(rival.cause, rival.axis)),
                        rival.probability,
                        rival.structural ? ", could imitate it in these rows" : "");
  }
  return html.empty() ? "none" : "<ul>\n" + html + "</ul>\n";
}

// Consecutive numbers as ranges: "1-40, 42".
std::string RowsText(std::vector<std::int64_t> rows) {
  std::ranges::sort(rows);
  std::string text;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    std::size_t end = i;
    while (end + 1 < rows.size() && rows[end + 1] == rows[end] + 1) ++end;
    text += text.empty() ? "" : ", ";
    text +=
        end > i ? fmt::format("{}-{}", rows[i], rows[end]) : fmt::format("{}", rows[i]);
    i = end;
  }
  return text;
}

std::string CausePage(const Diagnosis& diagnosis,
                      const PicturesData& data,
                      const DiagnosisReportNotes& notes,
                      std::size_t i) {
  const Finding& finding = diagnosis.findings[i];
  const auto effect = FindEffect(finding.cause);
  const Words words = effect ? EffectAt(*effect).words : Words{};
  const auto said = [](std::string_view text) {
    return Escaped(text);
  };
  std::string html = fmt::format(
      "<p>{}</p>\n", Escaped(FindingText(finding, diagnosis, notes.measured)));
  html += Drawing(FindingPicture(data.findings[i], i + 1), notes);
  html += "<dl class=\"cause\">\n";
  html += Item("plot", said(words.plot));
  html += Item("values", said(words.values) + ValuesHtml(finding));
  html += Item("cause", said(words.cause));
  html += Item("effect", said(words.effect));
  html += Item("action", said(words.action));
  html += Item("rivals", RivalsHtml(finding));
  html += Item("rows it rests on",
               fmt::format("{} rows that it moves; rows that see it: {}",
                           finding.rows,
                           RowsText(data.findings[i].rows)));
  return html + "</dl>\n";
}

std::string FlaggedTable(const PicturesData& data) {
  if (data.flagged.empty()) return "";
  std::string html =
      "<div class=\"scroll\" tabindex=\"0\"><table>\n<caption><span>Rows beyond 4.2 "
      "sigma of everything that fits were left out of every fit; rows that somebody "
      "marked were not.</span></caption>\n<thead><tr>";
  for (const char* heading : {"row",
                              "campaign",
                              "commanded x, y, z [mm]",
                              "value [mm]",
                              "left over [µm]",
                              "in sigma",
                              "left out",
                              "remark in the file"}) {
    html += fmt::format("<th scope=\"col\">{}</th>", heading);
  }
  html += "</tr></thead>\n<tbody>\n";
  for (const FlaggedRow& row : data.flagged) {
    std::string at;
    for (const double mm : row.cmd_mm) {
      at += (at.empty() ? "" : ", ") + NumberText(mm, 0.01);
    }
    html += fmt::format(
        "<tr><td class=\"number\">{}</td><td>{}</td><td>{}</td>"
        "<td class=\"number\">{:.4f}</td><td class=\"number\">{:+.1f}</td>"
        "<td class=\"number\">{:+.1f}</td><td>{}</td><td>{}</td></tr>\n",
        row.row,
        Escaped(row.campaign),
        at,
        row.value_mm,
        row.left_um,
        row.sigmas,
        row.is_out ? "yes" : "no",
        Escaped(row.flag));
  }
  return html + "</tbody></table></div>\n";
}

std::string TextHtml(const DiagnosisReportNotes& notes) {
  return fmt::format("<p class=\"verdict-text\">{}</p>\n",
                     Escaped(notes.text.substr(0, notes.text.find("\nBaseline"))));
}

std::string BaselineHtml(const Diagnosis& diagnosis) {
  if (diagnosis.baseline.empty()) return "";
  std::string html =
      "<div class=\"scroll\" tabindex=\"0\"><table>\n<caption><span>Always fitted, "
      "never "
      "a finding: built minus believed, one standard deviation.</span></caption>\n"
      "<thead><tr><th scope=\"col\">figure</th><th scope=\"col\">value</th></tr>"
      "</thead>\n<tbody>\n";
  for (const BaselineLine& line : diagnosis.baseline) {
    html += fmt::format("<tr><th scope=\"row\"><code>{}</code></th><td>{}</td></tr>\n",
                        Escaped(line.name),
                        Escaped(WithSd(line.value, line.sd, line.unit)));
  }
  return html + "</tbody></table></div>\n";
}

std::string ProvenanceHtml(const DiagnosisReportNotes& notes) {
  return fmt::format(
      "<p>caltwin {}, seed {}, rows of {}. The same version gives the same numbers; "
      "all "
      "that is drawn stands in <code>pictures.json</code> beside this page:</p>\n"
      "<pre><code>{} --report {}</code></pre>\n",
      Escaped(notes.version),
      notes.seed,
      Escaped(notes.data),
      Escaped(notes.command),
      Escaped(notes.folder));
}

std::vector<DiagnosisPicture> AllPictures(const Diagnosis& diagnosis,
                                          const PicturesData& data) {
  std::vector<DiagnosisPicture> all = {
      EvidencePicture(data), SharesPicture(diagnosis), LackOfFitPicture(data)};
  for (std::size_t i = 0; i < data.findings.size(); ++i) {
    all.push_back(FindingPicture(data.findings[i], i + 1));
  }
  for (const DirectionContrast& one : data.contrasts)
    all.push_back(ContrastPicture(one));
  for (const Periodogram& one : data.periodograms)
    all.push_back(PeriodogramPicture(one));
  std::erase_if(all, [](const DiagnosisPicture& one) { return one.svg.empty(); });
  return all;
}

struct Part {
  std::string id{}, title{}, html{};
};

std::vector<Part> Parts(const Diagnosis& diagnosis,
                        const PicturesData& data,
                        const DiagnosisReportNotes& notes) {
  const auto drawn = [&](const DiagnosisPicture& one) {
    return Drawing(one, notes);
  };
  std::string directions, waves;
  for (const DirectionContrast& one : data.contrasts) {
    directions += drawn(ContrastPicture(one));
  }
  for (const Periodogram& one : data.periodograms) {
    waves += drawn(PeriodogramPicture(one));
  }
  std::vector<Part> parts = {
      {"verdict", "What came out", TextHtml(notes)},
      {"evidence", "Where it is", drawn(EvidencePicture(data))},
      {"shares", "Who has which part", drawn(SharesPicture(diagnosis))}};
  for (std::size_t i = 0; i < diagnosis.findings.size(); ++i) {
    const Finding& finding = diagnosis.findings[i];
    parts.push_back({fmt::format("finding-{}", i + 1),
                     NameInWords(finding.cause, finding.axis),
                     CausePage(diagnosis, data, notes, i)});
  }
  parts.push_back({"fit", "What is left", drawn(LackOfFitPicture(data))});
  parts.push_back({"direction", "By direction", directions});
  parts.push_back({"waves", "Waves", waves});
  parts.push_back({"flagged", "Flagged rows", FlaggedTable(data)});
  parts.push_back({"baseline", "Baseline", BaselineHtml(diagnosis)});
  parts.push_back(
      {"provenance", "How to make this report again", ProvenanceHtml(notes)});
  std::erase_if(parts, [](const Part& part) { return part.html.empty(); });
  return parts;
}

}  // namespace

std::string DiagnosisReportHtml(const Diagnosis& diagnosis,
                                const PicturesData& data,
                                const DiagnosisReportNotes& notes) {
  std::string links, body;
  for (const Part& part : Parts(diagnosis, data, notes)) {
    links += fmt::format("<a href=\"#{}\">{}</a>\n", part.id, Escaped(part.title));
    body += Section(part.id, part.title, part.html);
  }
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"color-scheme\" content=\"light dark\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; "
      "style-src 'unsafe-inline'\">\n"
      "<title>Diagnosis of {} - caltwin</title>\n<style>\n{}{}</style>\n</head>\n"
      "<body>\n{}<nav aria-label=\"Sections\">\n{}</nav>\n<main>\n{}</main>\n</body>\n"
      "</html>\n",
      Escaped(notes.data),
      ReportCss(),
      kStyle,
      Header(diagnosis, notes),
      links,
      body);
}

void WriteDiagnosisReport(const Diagnosis& diagnosis,
                          const PicturesData& data,
                          const DiagnosisReportNotes& notes,
                          const std::filesystem::path& folder) {
  for (const DiagnosisPicture& picture : AllPictures(diagnosis, data)) {
    WriteTextFile(folder / (picture.name + ".svg"), picture.svg);
  }
  WriteTextFile(folder / "pictures.json", PicturesJson(data).dump() + "\n");
  WriteTextFile(folder / "index.html", DiagnosisReportHtml(diagnosis, data, notes));
}

}  // namespace caltwin

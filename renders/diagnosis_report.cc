#include "renders/diagnosis_report.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "calibration/diagnosis/diagnosis_summary.h"
#include "calibration/diagnosis/diagnosis_text.h"
#include "calibration/diagnosis/diagnosis_words.h"
#include "calibration/diagnosis/pictures_json.h"
#include "renders/diagnosis_pictures.h"
#include "renders/document.h"
#include "renders/html.h"
#include "renders/parts.h"
#include "sim/base/text_file.h"
#include "sim/base/units.h"
#include "sim/effects/catalog.h"

namespace caltwin {
namespace {

std::string Drawing(const DiagnosisPicture& picture,
                    const DiagnosisReportNotes& notes) {
  return FigureHtml(picture.title,
                    picture.caption,
                    picture.svg,
                    fmt::format("<pre><code>{} --report {}</code></pre>\n<p "
                                "class=\"kind\">{}/{}.svg</p>\n",
                                Escaped(notes.command),
                                Escaped(notes.folder),
                                Escaped(notes.folder),
                                picture.name));
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
                        SentenceHtml(WithSd(one.value, one.sd, unit)));
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
    return SentenceHtml(text);
  };
  std::string html =
      fmt::format("<p>{}</p>\n",
                  SentenceHtml(FindingText(finding, diagnosis, notes.words.measured)));
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
  // What was left out first; a table of a thousand remarks is read by nobody.
  constexpr std::size_t kMostShown = 50;
  std::vector<FlaggedRow> shown = data.flagged;
  std::ranges::stable_partition(shown, &FlaggedRow::is_out);
  const std::size_t more = shown.size() - std::min(shown.size(), kMostShown);
  shown.resize(shown.size() - more);
  std::string html;
  for (const FlaggedRow& row : shown) {
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
  const std::string rest =
      more == 0 ? "" : fmt::format(" {} more are in the JSON.", more);
  return TableHtml(
      "Rows beyond 4.2 sigma of everything that fits were left out of every fit; rows "
      "that somebody marked were not." +
          rest,
      {"row",
       "campaign",
       "commanded x, y, z [mm]",
       "value [mm]",
       "left over [µm]",
       "in sigma",
       "left out",
       "remark in the file"},
      html);
}

std::string Group(std::string_view title, const std::vector<std::string>& sentences) {
  const std::string list = ListHtml(sentences);
  return list.empty() ? "" : fmt::format("<h3>{}</h3>\n{}", title, list);
}

std::string MeaningHtml(const Diagnosis& diagnosis,
                        const DiagnosisSummary& summary,
                        const DiagnosisReportNotes& notes) {
  return Group("What was found", summary.found) +
         Group("What these measurements cannot tell", summary.cannot_tell) +
         Group("What to do", summary.to_do) +
         Group("How the data were read", diagnosis.remarks) +
         fmt::format(
             "<details><summary>The whole answer, as the terminal shows it"
             "</summary>\n<pre class=\"words\">{}</pre></details>\n",
             Escaped(notes.text));
}

std::string BaselineHtml(const Diagnosis& diagnosis) {
  std::string rows;
  for (const BaselineLine& line : diagnosis.baseline) {
    rows += fmt::format("<tr><th scope=\"row\"><code>{}</code></th><td>{}</td></tr>\n",
                        Escaped(line.name),
                        SentenceHtml(WithSd(line.value, line.sd, line.unit)));
  }
  return TableHtml(
      "Always fitted, never a finding: built minus believed, one standard "
      "deviation.",
      {"figure", "value"},
      rows);
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

std::vector<DocumentDrawing> Drawings(const Diagnosis& diagnosis,
                                      const PicturesData& data) {
  std::vector<DiagnosisPicture> all = {
      EvidencePicture(data), SharesPicture(diagnosis), LackOfFitPicture(data)};
  for (std::size_t i = 0; i < data.findings.size(); ++i) {
    all.push_back(FindingPicture(data.findings[i], i + 1));
  }
  for (const DirectionContrast& one : data.contrasts) {
    all.push_back(ContrastPicture(one));
  }
  for (const Periodogram& one : data.periodograms) {
    all.push_back(PeriodogramPicture(one));
  }
  std::vector<DocumentDrawing> drawings;
  for (const DiagnosisPicture& one : all) drawings.push_back({one.name, one.svg});
  return drawings;
}

std::vector<DocumentSection> Sections(const Diagnosis& diagnosis,
                                      const PicturesData& data,
                                      const DiagnosisReportNotes& notes,
                                      const DiagnosisSummary& summary) {
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
  std::vector<DocumentSection> parts = {
      {"meaning", "What it means", MeaningHtml(diagnosis, summary, notes)},
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
  return parts;
}

Tone ToneOf(DiagnosisSummary::Answer answer) {
  switch (answer) {
    case DiagnosisSummary::Answer::kNothing:
      return Tone::kGood;
    case DiagnosisSummary::Answer::kTooFew:
      return Tone::kPlain;
    case DiagnosisSummary::Answer::kCause:
    case DiagnosisSummary::Answer::kFigure:
    case DiagnosisSummary::Answer::kElsewhere:
      return Tone::kWarn;
  }
  return Tone::kPlain;
}

Document DocumentOf(const Diagnosis& diagnosis,
                    const PicturesData& data,
                    const DiagnosisReportNotes& notes) {
  const GainFigures& gain = diagnosis.gain;
  const DiagnosisSummary summary = SummaryOf(diagnosis, notes.words);
  return {
      .kind = "diagnosis",
      .name = std::filesystem::path(notes.data).filename().string(),
      .about = "",
      .tone = ToneOf(summary.answer),
      .verdict = summary.sentence,
      .tiles = {{"verdict on causes", ToString(diagnosis.verdict)},
                {"rms before, rows left out", LengthText(gain.blocks.before_mm)},
                {"rms after, rows left out", LengthText(gain.blocks.after_mm)},
                {"noise floor", LengthText(gain.noise_floor_mm)},
                {"readings", fmt::format("{}", diagnosis.residual_before_mm.size())}},
      .sections = Sections(diagnosis, data, notes, summary),
      .drawings = Drawings(diagnosis, data)};
}

}  // namespace

std::string DiagnosisReportHtml(const Diagnosis& diagnosis,
                                const PicturesData& data,
                                const DiagnosisReportNotes& notes) {
  return DocumentHtml(DocumentOf(diagnosis, data, notes));
}

void WriteDiagnosisReport(const Diagnosis& diagnosis,
                          const PicturesData& data,
                          const DiagnosisReportNotes& notes,
                          const std::filesystem::path& folder) {
  WriteTextFile(folder / "pictures.json", PicturesJson(data).dump() + "\n");
  WriteDocument(DocumentOf(diagnosis, data, notes), folder);
}

}  // namespace caltwin

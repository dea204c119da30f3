#include "renders/report.h"

#include <algorithm>
#include <string_view>

#include <fmt/format.h>

#include "renders/assets.h"
#include "renders/html.h"
#include "renders/sections/sections.h"
#include "sim/base/text_file.h"

namespace caltwin {
namespace {

std::string Name(const RunResult& result) {
  const std::string stem = std::filesystem::path(result.scenario).stem().string();
  return stem.empty() ? "run" : stem;
}

std::string Tile(std::string_view value, std::string_view label) {
  return fmt::format(
      "<div><dt>{}</dt><dd>{}</dd></div>\n", Escaped(label), Escaped(value));
}

std::string Tiles(const RunResult& result) {
  const auto num_checked = std::ranges::count_if(
      result.parameters, [](const auto& p) { return p.passed.has_value(); });
  const auto num_passed = std::ranges::count_if(
      result.parameters, [](const auto& p) { return p.passed.value_or(false); });
  std::string html = "<dl class=\"tiles\">\n";
  html += Tile(fmt::format("{} of {}", num_passed, num_checked),
               "quantities within tolerance");
  html += Tile(result.outcome, "outcome");
  html += Tile(result.fidelity, "fidelity");
  html += Tile(fmt::format("{}", result.touches), "touches");
  html += Tile(DurationText(result.machine_time_s), "machine time");
  return html + "</dl>\n";
}

std::string Header(const RunResult& result) {
  return fmt::format(
      "<header>\n<p class=\"brand\">caltwin</p>\n<h1>{} <span class=\"badge {}\">{}"
      "</span></h1>\n<p class=\"about\">{}</p>\n{}</header>\n",
      Escaped(Name(result)),
      result.passed ? "good" : "bad",
      result.passed ? "passed" : "failed",
      Escaped(result.about),
      Tiles(result));
}

std::string Body(const RunResult& result, const ReportPictures& pictures) {
  std::string links, body;
  for (const Section& section : AllSections()) {
    const std::string html = section.html(result, pictures);
    if (html.empty()) continue;
    links += fmt::format("<a href=\"#{}\">{}</a>\n", section.id, section.title);
    body += fmt::format(
        "<section id=\"{0}\" aria-labelledby=\"{0}-title\">\n"
        "<h2 id=\"{0}-title\">{1}</h2>\n{2}</section>\n",
        section.id,
        section.title,
        html);
  }
  return fmt::format("{}<nav aria-label=\"Sections\">\n{}</nav>\n<main>\n{}</main>\n",
                     Header(result),
                     links,
                     body);
}

}  // namespace

std::string ReportHtml(const RunResult& result, const ReportPictures& pictures) {
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"color-scheme\" content=\"light dark\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; "
      "img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'\">\n"
      "<title>{} {} - caltwin</title>\n<style>\n{}\n{}</style>\n</head>\n<body>\n{}"
      "<noscript><p>The plots need JavaScript; everything else does "
      "not.</p></noscript>\n"
      "<script>\n{}\n</script>\n<script>\n{}\n</script>\n</body>\n</html>\n",
      Escaped(Name(result)),
      result.passed ? "passed" : "failed",
      PlotLibraryCss(),
      ReportCss(),
      Body(result, pictures),
      PlotLibrary(),
      ReportScript());
}

void WriteReport(const RunResult& result,
                 const ReportPictures& pictures,
                 const std::filesystem::path& folder) {
  WriteTextFile(folder / "index.html", ReportHtml(result, pictures));
}

}  // namespace caltwin

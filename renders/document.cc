#include "renders/document.h"

#include <string_view>

#include <fmt/format.h>

#include "renders/assets.h"
#include "renders/html.h"
#include "sim/base/text_file.h"

namespace caltwin {
namespace {

std::string VerdictHtml(const Document& document) {
  if (document.verdict.empty()) return "";
  std::string html =
      fmt::format("<div class=\"verdict {}\">\n<p><strong>{}</strong></p>\n",
                  ClassOf(document.tone),
                  SentenceHtml(document.verdict));
  for (const std::string& remark : document.remarks) {
    html += fmt::format("<p>{}</p>\n", SentenceHtml(remark));
  }
  return html + "</div>\n";
}

std::string Tiles(const Document& document) {
  if (document.tiles.empty()) return "";
  std::string html = "<dl class=\"tiles\">\n";
  for (const DocumentTile& tile : document.tiles) {
    html += fmt::format("<div><dt>{}</dt><dd>{}</dd></div>\n",
                        Escaped(tile.label),
                        Escaped(tile.value));
  }
  return html + "</dl>\n";
}

std::string Header(const Document& document) {
  return fmt::format(
      "<header>\n<p class=\"brand\">caltwin <span>{}</span></p>\n<h1>{}</h1>\n{}{}{}"
      "</header>\n",
      Escaped(document.kind),
      Escaped(document.name),
      document.about.empty()
          ? ""
          : fmt::format("<p class=\"about\">{}</p>\n", Escaped(document.about)),
      VerdictHtml(document),
      Tiles(document));
}

std::string Body(const Document& document) {
  std::string links, body;
  for (const DocumentSection& section : document.sections) {
    if (section.html.empty()) continue;
    links +=
        fmt::format("<a href=\"#{}\">{}</a>\n", section.id, Escaped(section.title));
    body += fmt::format(
        "<section id=\"{0}\" aria-labelledby=\"{0}-title\">\n"
        "<h2 id=\"{0}-title\">{1}</h2>\n{2}</section>\n",
        section.id,
        Escaped(section.title),
        section.html);
  }
  return fmt::format("{}<nav aria-label=\"Sections\">\n{}</nav>\n<main>\n{}</main>\n",
                     Header(document),
                     links,
                     body);
}

}  // namespace

std::string DocumentHtml(const Document& document) {
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"color-scheme\" content=\"light dark\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; "
      "img-src data:; style-src 'unsafe-inline'{}\">\n"
      "<title>{}: {} - caltwin</title>\n<style>\n{}{}</style>\n</head>\n<body>\n{}"
      "</body>\n</html>\n",
      document.has_script ? "; script-src 'unsafe-inline'" : "",
      Escaped(document.name),
      Escaped(document.kind),
      PaletteCss(),
      ReportCss(),
      Body(document));
}

void WriteDocument(const Document& document, const std::filesystem::path& folder) {
  for (const DocumentDrawing& drawing : document.drawings) {
    if (drawing.svg.empty()) continue;
    // A name may come from a file.
    std::string name = drawing.name;
    for (char& c : name) {
      if (c == '/' || c == ':' || c == ' ') c = '_';
    }
    WriteTextFile(folder / (name + ".svg"), drawing.svg);
  }
  WriteTextFile(folder / "index.html", DocumentHtml(document));
}

}  // namespace caltwin

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "renders/parts.h"

namespace caltwin {

/// One part of a document under its own heading.
struct DocumentSection {
  std::string id{};  ///< Of its anchor.
  std::string title{};
  std::string html{};  ///< Empty: it is left out.
};

/// A figure that is read at a glance.
struct DocumentTile {
  std::string label{};
  std::string value{};
};

/// A drawing of a document, also written as a file beside it.
struct DocumentDrawing {
  std::string name{};  ///< Of its file, without ".svg".
  std::string svg{};
};

/// A report as a person reads it: what came out in one sentence, the figures behind it,
/// then the sections. All is text but the sections' `html`.
struct Document {
  std::string kind{};  ///< "Run", "Diagnosis", "Study": over the name.
  std::string name{};
  std::string about{};
  Tone tone = Tone::kPlain;
  std::string verdict{};               ///< One sentence; empty: none is due.
  std::vector<std::string> remarks{};  ///< Sentences that go with it.
  std::vector<DocumentTile> tiles{};
  std::vector<DocumentSection> sections{};
  std::vector<DocumentDrawing> drawings{};
  bool has_script = false;  ///< A section brings one; else none may run.
};

/// The document as one HTML page that loads nothing: style, pictures and data are
/// inside. It prints on A4. The same document gives the same bytes.
std::string DocumentHtml(const Document& document);

/// Writes it as `folder/index.html`, each of its drawings as `folder/NAME.svg` beside
/// it. Throws InputError where that cannot be done.
void WriteDocument(const Document& document, const std::filesystem::path& folder);

}  // namespace caltwin

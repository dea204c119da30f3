#include "renders/report.h"

#include <algorithm>

#include <fmt/format.h>

#include "renders/document.h"
#include "renders/html.h"
#include "renders/sections/sections.h"
#include "scenarios/verdict_text.h"

namespace caltwin {
namespace {

std::string Name(const RunResult& result) {
  const std::string stem = std::filesystem::path(result.scenario).stem().string();
  return stem.empty() ? "run" : stem;
}

std::vector<DocumentTile> Tiles(const RunResult& result) {
  const auto num_checked = std::ranges::count_if(
      result.parameters, [](const auto& p) { return p.passed.has_value(); });
  const auto num_passed = std::ranges::count_if(
      result.parameters, [](const auto& p) { return p.passed.value_or(false); });
  std::vector<DocumentTile> tiles;
  if (num_checked > 0) {
    tiles.push_back({"quantities within tolerance",
                     fmt::format("{} of {}", num_passed, num_checked)});
  }
  tiles.push_back({"outcome", result.outcome});
  tiles.push_back({"machine", result.machine});
  tiles.push_back({"fidelity", result.fidelity});
  tiles.push_back({"touches", fmt::format("{}", result.touches)});
  tiles.push_back({"machine time", DurationText(result.machine_time_s)});
  return tiles;
}

Document DocumentOf(const RunResult& result, const ReportPictures& pictures) {
  const RunVerdict verdict = VerdictOf(result);
  Document document{
      .kind = result.passed ? "run, passed" : "run, failed",
      .name = Name(result),
      .about = result.about,
      .tone = result.passed ? Tone::kGood : Tone::kBad,
      .verdict = (result.passed ? "Passed. " : "Failed. ") + verdict.sentence,
      .remarks = verdict.remarks,
      .tiles = Tiles(result),
      .has_script = !pictures.playback.empty()};
  for (const Section& section : AllSections()) {
    document.sections.push_back({std::string(section.id),
                                 std::string(section.title),
                                 section.html(result, pictures)});
  }
  return document;
}

}  // namespace

std::string ReportHtml(const RunResult& result, const ReportPictures& pictures) {
  return DocumentHtml(DocumentOf(result, pictures));
}

void WriteReport(const RunResult& result,
                 const ReportPictures& pictures,
                 const std::filesystem::path& folder) {
  WriteDocument(DocumentOf(result, pictures), folder);
}

}  // namespace caltwin

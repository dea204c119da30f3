#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "scenarios/result.h"

namespace caltwin {

/// One picture of a report.
struct ReportPicture {
  std::string title{};    ///< "Before", "After".
  std::string caption{};  ///< What it shows, at which scale.
  std::string png{};      ///< The bytes of a PNG file.
};

/// The pictures of a report, in the order shown; none: the report has no such section.
struct ReportPictures {
  std::vector<ReportPicture> pictures{};
  std::string playback{};  ///< Of PlaybackHtml; empty: there is no such section.
};

/// The report of a run as one HTML document that loads nothing: style, script, data and
/// pictures are inside. The same result and pictures give the same bytes. Everything
/// that comes from files is escaped.
std::string ReportHtml(const RunResult& result, const ReportPictures& pictures);

/// Writes it as `folder/index.html`. Throws InputError where that cannot be done.
void WriteReport(const RunResult& result,
                 const ReportPictures& pictures,
                 const std::filesystem::path& folder);

}  // namespace caltwin

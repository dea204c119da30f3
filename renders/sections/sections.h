#pragma once

#include <span>
#include <string>
#include <string_view>

#include "renders/report.h"
#include "scenarios/result.h"

namespace caltwin {

/// One part of a report under its own heading.
struct Section {
  std::string_view id;  ///< Of its anchor.
  std::string_view title;
  /// Its HTML; empty where this run has nothing to show, and then it is left out.
  std::string (*html)(const RunResult& result, const ReportPictures& pictures);
};

/// Every section there is, in the order of the page.
std::span<const Section> AllSections();

/// @name One function a file: sections/NAME.cc.
std::string VerdictSection(const RunResult& result, const ReportPictures& pictures);
std::string UncertaintySection(const RunResult& result, const ReportPictures& pictures);
std::string PicturesSection(const RunResult& result, const ReportPictures& pictures);
std::string PlaybackSection(const RunResult& result, const ReportPictures& pictures);
std::string PositionSection(const RunResult& result, const ReportPictures& pictures);
std::string StepsSection(const RunResult& result, const ReportPictures& pictures);
std::string ConvergenceSection(const RunResult& result, const ReportPictures& pictures);
std::string ReadingsSection(const RunResult& result, const ReportPictures& pictures);
/// What was found, what these measurements cannot tell, what to do.
std::string MeaningSection(const RunResult& result, const ReportPictures& pictures);
std::string ProvenanceSection(const RunResult& result, const ReportPictures& pictures);

}  // namespace caltwin

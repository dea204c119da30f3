#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "scenarios/study/budget.h"
#include "scenarios/study/summary.h"

namespace caltwin {

/// What a study came to.
struct StudyFindings {
  StudySummary summary{};
  std::vector<std::vector<Budget>> budgets{};  ///< By contender; empty: not known.
  std::string remarks{};  ///< As the terminal shows it: settling, linear's check.
};

/// The report of a study as one HTML document that loads nothing and needs no script:
/// how sure, how often right, where errors come from, the worst machines with the
/// command that replays each.
std::string StudyReportHtml(const Study& study, const StudyFindings& findings);

/// Writes it as `folder/index.html`, and each of its pictures beside it as SVG.
void WriteStudyReport(const Study& study,
                      const StudyFindings& findings,
                      const std::filesystem::path& folder);

}  // namespace caltwin

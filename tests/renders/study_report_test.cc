// The report of a study says what the summary says, escaped, and loads nothing.

#include "renders/study_report.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "renders/study_pictures.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

ParameterSummary Gap() {
  ParameterSummary gap{.name = "backlash.x",
                       .unit = "mm",
                       .error = {.count = 100, .mean = 1e-5, .sd = 5e-4},
                       .identified = RateOf(100, 100),
                       .coverage95 = RateOf(94, 100),
                       .mean_sd = 4.9e-4,
                       .rms_over_sd = 1.02,
                       .stated = {.u = 4.7e-4, .dof = 16.7, .k = 2.12, .U = 9.96e-4}};
  gap.histogram = EmptyHistogram(gap.error);
  CountIn(0, 60, &gap.histogram);
  CountIn(4e-4, 40, &gap.histogram);
  return gap;
}

StudyFindings Findings() {
  CaseSummary one{.name = "first <light>",
                  .status = {{"recovers", 100}},
                  .parameters = {Gap(), {.name = "tip_size", .unit = "mm"}},
                  .worst = {17}};
  return {.summary = {.trials = 100, .cases = {one}},
          .budgets = {{{.name = "backlash.x",
                        .unit = "mm",
                        .u = 5e-4,
                        .lines = {{.input = "built.probe.hysteresis_mm",
                                   .u = 5e-4,
                                   .c = 0.8,
                                   .contribution = 4e-4,
                                   .share = 0.64}}}}},
          .remarks = "settled"};
}

Study Named() {
  Study study;
  study.file = "next.yaml";
  study.about = "How <sure>?";
  study.verbatim = "study: {trials: 100}";
  return study;
}

TEST(StudyReport, SaysHowSureHowOftenAndWhereFrom) {
  const std::string html = StudyReportHtml(Named(), Findings());

  EXPECT_THAT(html,
              AllOf(HasSubstr("94.0 (87.5 to 97.2)"),
                    HasSubstr(">0.00100</td><td class=\"number\">2.12</td>"
                              "<td class=\"number\">16</td>"),
                    HasSubstr("64.0 %"),
                    HasSubstr("built.probe.hysteresis_mm"),
                    HasSubstr("caltwin study next.yaml --trial 17"),
                    HasSubstr("not told or without a stated uncertainty: "
                              "<code>tip_size</code>"),
                    HasSubstr("study: {trials: 100}")));
  EXPECT_THAT(html, AllOf(Not(HasSubstr("<sure>")), Not(HasSubstr("first <light>"))));
  EXPECT_THAT(html, AllOf(Not(HasSubstr("src=")), Not(HasSubstr("<script"))));
}

TEST(StudyReport, LeavesItsPicturesBesideThePage) {
  const fs::path folder = fs::path(::testing::TempDir()) / "study_report";
  fs::remove_all(folder);
  WriteStudyReport(Named(), Findings(), folder);

  EXPECT_TRUE(fs::is_regular_file(folder / "index.html"));
  EXPECT_TRUE(fs::is_regular_file(folder / "coverage.svg"));
  EXPECT_TRUE(fs::is_regular_file(folder / "errors_backlash.x.svg"));
  EXPECT_FALSE(fs::exists(folder / "errors_tip_size.svg"));
}

// 40 of 100 fall into one part; beyond the ends counts into the last ones.
TEST(HistogramOfErrors, CountsEverythingOnce) {
  Histogram histogram = Gap().histogram;
  CountIn(-1, 1, &histogram);
  CountIn(1, 2, &histogram);

  EXPECT_EQ(histogram.counts.front(), 1);
  EXPECT_EQ(histogram.counts.back(), 2);
  EXPECT_EQ(histogram.counts[histogram.counts.size() / 2], 60);
  EXPECT_EQ(std::ranges::count(histogram.counts, 40), 1);
  EXPECT_EQ(HistogramSvg({}), "");
  EXPECT_EQ(CoverageSvg({}), "");
}

}  // namespace
}  // namespace caltwin

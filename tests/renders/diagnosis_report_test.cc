#include "renders/diagnosis_report.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <numbers>
#include <numeric>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "calibration/diagnosis/diagnosis.h"
#include "calibration/diagnosis/pictures_json.h"
#include "renders/diagnosis_pictures.h"
#include "sim/base/rng.h"
#include "sim/base/text_file.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kLead_mm = 4, kAmplitude_um = 5, kSigma_um = 0.5;
constexpr int kPositions = 30;
constexpr double kSpan_mm = 200;

// A laser along x at random positions, both ways; the screw errs once per turn.
RowTable WavyAxis() {
  Rng rng(4, 0, "diagnosis_report_test");
  RowTable table;
  const auto add = [&](double q_mm, double dir) {
    Row row{.row = static_cast<std::int64_t>(table.rows.size()) + 1,
            .campaign = "x <1>"};
    row.setup = "laser";
    row.t_s = 10.0 * static_cast<double>(table.rows.size());
    row.cmd_mm = {q_mm, 0, 0};
    row.dir = {dir, 0, 0};
    row.n = {1, 0, 0};
    row.sigma_mm = kSigma_um * 1e-3;
    row.value_mm =
        1e-3 * (kAmplitude_um * std::sin(2 * std::numbers::pi * q_mm / kLead_mm) +
                kSigma_um * rng.Normal());
    table.rows.push_back(row);
  };
  std::vector<double> positions_mm;
  for (int i = 0; i < kPositions; ++i) {
    positions_mm.push_back(kSpan_mm * (i + rng.Uniform()) / kPositions);
  }
  for (const double q_mm : positions_mm) add(q_mm, 1);
  for (auto it = positions_mm.rbegin(); it != positions_mm.rend(); ++it) add(*it, -1);
  return table;
}

struct Sample {
  Observed observed;
  Diagnosis diagnosis{};
  PicturesData data{};
};

const Sample& Wavy() {
  static const Sample sample = [] {
    Machine machine{.name = "test"};
    machine.settings.steps_per_mm = {800, 800, 800};
    Sample made{.observed = Observed(WavyAxis(), {}, machine, {})};
    made.diagnosis = Diagnose(made.observed, {});
    made.data = PicturesDataOf(made.observed, made.diagnosis);
    return made;
  }();
  return sample;
}

DiagnosisReportNotes Notes() {
  return {.data = "<x>.csv",
          .text = "Verdict: named.",
          .command = "caltwin diagnose x.csv",
          .folder = "out/report",
          .version = "0"};
}

TEST(DiagnosisReport, HoldsTheNumbersOfTheDiagnosis) {
  const Sample& sample = Wavy();
  ASSERT_EQ(sample.diagnosis.findings.size(), 1U);
  const Finding& finding = sample.diagnosis.findings[0];

  const std::string html = DiagnosisReportHtml(sample.diagnosis, sample.data, Notes());

  EXPECT_EQ(finding.cause, "cyclic_lead");
  EXPECT_THAT(html, HasSubstr(fmt::format("log odds {:.1f}", finding.log_odds)));
  EXPECT_THAT(html, HasSubstr(fmt::format("share {:.1f} %", 100 * finding.share)));
  EXPECT_THAT(html, HasSubstr("<code>amplitude_um</code>"));
  EXPECT_THAT(html,
              HasSubstr(fmt::format("{:.2f} µm</text>",
                                    sample.data.lack_of_fit.at(0).before_um)));
}

TEST(DiagnosisReport, NamesTheCommandUnderEveryPicture) {
  const std::string html = DiagnosisReportHtml(Wavy().diagnosis, Wavy().data, Notes());

  std::size_t figures = 0, commands = 0;
  const std::string command = "caltwin diagnose x.csv --report out/report</code>";
  for (std::size_t at = html.find("</figure>"); at != std::string::npos;
       at = html.find("</figure>", at + 1)) {
    ++figures;
  }
  for (std::size_t at = html.find(command); at != std::string::npos;
       at = html.find(command, at + 1)) {
    ++commands;
  }
  EXPECT_GE(figures, 5U);
  EXPECT_EQ(commands, figures + 1);  // Once more at the end.
}

TEST(DiagnosisReport, EscapesWhatComesFromFiles) {
  const std::string html = DiagnosisReportHtml(Wavy().diagnosis, Wavy().data, Notes());

  EXPECT_THAT(html, Not(HasSubstr("x <1>")));
  EXPECT_THAT(html, Not(HasSubstr("<x>")));
  EXPECT_THAT(html, HasSubstr("x &lt;1&gt;"));
}

TEST(DiagnosisReport, LoadsNothing) {
  const std::string html = DiagnosisReportHtml(Wavy().diagnosis, Wavy().data, Notes());

  EXPECT_THAT(html, Not(HasSubstr("<script")));
  EXPECT_THAT(html, Not(HasSubstr("src=")));
}

TEST(DiagnosisReport, HasNoPagesWhereNothingIsFound) {
  const std::string html = DiagnosisReportHtml({}, {}, Notes());

  EXPECT_THAT(html, HasSubstr("<dd>none</dd>"));
  EXPECT_THAT(html, Not(HasSubstr("id=\"finding-1\"")));
  EXPECT_THAT(html, Not(HasSubstr("<svg")));
}

TEST(DiagnosisReport, WritesEveryPictureAndItsNumbers) {
  const std::filesystem::path folder =
      std::filesystem::path(::testing::TempDir()) / "diagnosis_report_test";

  WriteDiagnosisReport(Wavy().diagnosis, Wavy().data, Notes(), folder);

  for (const char* name : {"index.html",
                           "evidence_map.svg",
                           "shares.svg",
                           "finding_1.svg",
                           "periodogram_x.svg",
                           "direction_x.svg",
                           "lack_of_fit.svg"}) {
    EXPECT_TRUE(std::filesystem::exists(folder / name)) << name;
  }
  const auto json =
      nlohmann::json::parse(ReadTextFile(folder / "pictures.json", 1'000'000));
  EXPECT_EQ(json.at("findings").at(0).at("rows").size(), 2U * kPositions);
  std::filesystem::remove_all(folder);
}

TEST(DiagnosisPictures, SharesSumToAHundredPercent) {
  const Diagnosis diagnosis{
      .findings = {{.cause = "backlash_worn", .axis = "x", .share = 0.61},
                   {.cause = "cyclic_lead", .axis = "y", .share = 0.29}}};

  const std::vector<double> shares = SharesInPercent(diagnosis);

  ASSERT_EQ(shares.size(), 3U);
  EXPECT_DOUBLE_EQ(std::accumulate(shares.begin(), shares.end(), 0.0), 100);
  EXPECT_NEAR(shares[2], 10, 1e-9);
  EXPECT_THAT(SharesPicture(diagnosis).svg, HasSubstr("10.0 %"));
}

TEST(DiagnosisPictures, PeriodogramPeaksAtThePeriodOfTheWave) {
  const auto& periodograms = Wavy().data.periodograms;
  ASSERT_EQ(periodograms.size(), 1U);
  const Periodogram& wave = periodograms[0];

  const double peak_mm = PeakPeriod_mm(wave);

  // Half a resolvable line: one wave more or less over the span.
  EXPECT_NEAR(kSpan_mm / peak_mm, kSpan_mm / kLead_mm, 0.5);
  const double highest_um = *std::ranges::max_element(
      wave.before_um, [](double a, double b) { return !(a >= b) && std::isfinite(b); });
  // Between two frequencies asked for, up to a tenth is lost.
  EXPECT_NEAR(highest_um, kAmplitude_um, kAmplitude_um / 10 + 4 * kSigma_um / 6);
  EXPECT_LT(wave.noise_um, kAmplitude_um / 5);
}

TEST(DiagnosisPictures, PeriodogramSaysWhatRegularSpacingHides) {
  RowTable regular = WavyAxis();
  for (std::size_t i = 0; i < regular.rows.size(); ++i) {
    const std::size_t at = i < kPositions ? i : 2 * kPositions - 1 - i;
    regular.rows[i].cmd_mm[0] = kLead_mm * static_cast<double>(at);
    regular.rows[i].value_mm = 0;
  }
  const Observed observed(regular, {}, Wavy().observed.machine(), {});
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(observed.num_rows());
  const Diagnosis diagnosis{.residual_before_mm = none,
                            .residual_after_mm = none,
                            .sigma_mm = none.array() + kSigma_um * 1e-3};

  const auto shape = PeriodogramOf(observed, diagnosis, Axis::kX);

  ASSERT_TRUE(shape.has_value());
  int hidden = 0;
  for (std::size_t i = 0; i < shape->period_mm.size(); ++i) {
    if (std::abs(kSpan_mm / shape->period_mm[i] - kSpan_mm / kLead_mm) > 0.2) continue;
    ++hidden;
    EXPECT_TRUE(std::isnan(shape->before_um[i])) << shape->period_mm[i];
  }
  EXPECT_GT(hidden, 0);
}

TEST(DiagnosisPictures, BestCellOfTheEvidenceMapIsTheFindings) {
  const Sample& sample = Wavy();
  const Finding& finding = sample.diagnosis.findings.at(0);

  const EvidenceCell best =
      std::ranges::max(sample.data.evidence_map, {}, &EvidenceCell::log_odds);

  EXPECT_EQ(best.cause, finding.cause);
  EXPECT_EQ(best.channel, "x");
  EXPECT_EQ(best.covariate, finding.covariates.at(0));
  EXPECT_EQ(best.log_odds, sample.diagnosis.evidence.at(0).log_odds);
}

TEST(DiagnosisPictures, MapHasTheBestOfEachCellAlsoBelowTheFirstTwelve) {
  std::vector<EvidenceLine> weighed;
  for (int i = 0; i < 20; ++i) {
    weighed.push_back({"cyclic_lead", "x", {"x"}, 50.0 - i, "x"});
  }
  weighed.push_back({"thermal_screw", "y", {"y", "temp"}, -1.5, "y"});

  const std::vector<EvidenceCell> cells = EvidenceMapOf(weighed);

  ASSERT_EQ(cells.size(), 3U);
  EXPECT_EQ(cells[0].log_odds, 50);
  EXPECT_EQ(cells[1].cause, "thermal_screw");
  EXPECT_EQ(cells[2].covariate, "temp");
}

TEST(DiagnosisPictures, AfterTheFindingOnlyNoiseIsLeft) {
  const FindingSeries& series = Wavy().data.findings.at(0);
  const auto rms = [](const std::vector<double>& values) {
    const double sum =
        std::inner_product(values.begin(), values.end(), values.begin(), 0.0);
    return std::sqrt(sum / static_cast<double>(values.size()));
  };

  EXPECT_GT(rms(series.before_um), 0.6 * kAmplitude_um);  // A sine's rms is 0.71 of it.
  EXPECT_LT(rms(series.after_um), 1.3 * kSigma_um);
  EXPECT_NEAR(series.period_mm, kLead_mm, 0.05);
}

TEST(DiagnosisPictures, JsonHoldsWhatIsDrawn) {
  const PicturesData& data = Wavy().data;

  const auto json = ShowJson(data);

  EXPECT_EQ(json.at("evidence_map").size(), data.evidence_map.size());
  EXPECT_EQ(json.at("lack_of_fit").at(0).at("after_um"), data.lack_of_fit[0].after_um);
  EXPECT_EQ(json.at("periodograms").at(0).at("peaks").at(0).at("period_mm"),
            PeakPeriod_mm(data.periodograms[0]));
}

}  // namespace
}  // namespace caltwin

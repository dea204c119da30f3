#include "renders/diagnosis_pictures.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calibration/diagnosis/diagnosis_words.h"
#include "renders/chart.h"
#include "sim/base/units.h"
#include "sim/machine/axis.h"

namespace caltwin {
namespace {

std::string Letter(std::string_view axis) {
  std::string letter(axis);
  for (char& c : letter)
    c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return letter;
}

// What a channel's error is called on an axis of a chart.
std::string ErrorLabel(std::string_view channel) {
  if (channel == "probe") return "pre-travel error [µm]";
  if (channel == "bed") return "height error of the bed [µm]";
  return fmt::format("error along {} [µm]", Letter(channel));
}

// A covariate's scale: seconds become minutes or hours, whichever suits.
struct CovariateScale {
  std::string label{};
  double unit = 1;
};

std::string InWords(std::string_view covariate) {
  if (covariate == "temp_frame_c") return "temperature of the frame";
  if (covariate == "temp_bed_c") return "temperature of the bed";
  if (covariate == "temp_screw_c") return "temperature of the screw";
  return CovariateInWords(covariate);
}

CovariateScale ScaleOf(const FindingSeries& series) {
  constexpr double kMinute_s = 60, kHour_s = 3600;
  const std::string words = InWords(series.covariate);
  if (series.period_mm > 0) {
    return {fmt::format("{}, folded by {:.4g} mm [mm]", words, series.period_mm)};
  }
  if (AxisNamed(series.covariate)) return {words + " [mm]"};
  if (series.covariate == "t") {
    if (series.is_by_order) return {"order of the rows"};
    const auto [min, max] = std::ranges::minmax(series.at);
    if (max - min > 3 * kHour_s) return {"time [h]", kHour_s};
    return {"time [min]", kMinute_s};
  }
  if (series.covariate == "temp") return {"rise of temperature [K]"};
  if (series.covariate.starts_with("temp_")) return {words + " [°C]"};
  if (series.covariate == "feed") return {"feed [mm/s]"};
  if (series.covariate == "load") return {"load [N]"};
  if (series.covariate == "since_rev") return {words + " [mm]"};
  if (series.covariate == "theta") return {words + " [deg]"};
  return {words};
}

struct Pair {
  std::vector<double> at{}, before_um{}, after_um{};
};

// The rows of one class; -1: all.
Pair RowsOf(const FindingSeries& series, int part, double unit) {
  Pair rows;
  for (std::size_t i = 0; i < series.at.size(); ++i) {
    if (part >= 0 && series.split[i] != part) continue;
    rows.at.push_back(series.at[i] / unit);
    rows.before_um.push_back(series.before_um[i]);
    rows.after_um.push_back(series.after_um[i]);
  }
  return rows;
}

}  // namespace

DiagnosisPicture FindingPicture(const FindingSeries& series, std::size_t number) {
  DiagnosisPicture picture{
      .name = fmt::format("finding_{}", number),
      .title = NameInWords(series.cause, series.axis),
      .caption = fmt::format(
          "What is left of each reading, all other findings corrected, against {}: "
          "without this finding, and with it. The band is two standard deviations of "
          "a reading, {:.2g} µm.",
          InWords(series.covariate),
          2 * series.pure_error_um)};
  if (series.at.empty()) return picture;
  const CovariateScale scale = ScaleOf(series);
  const Pair all = RowsOf(series, -1, scale.unit);
  const std::vector<double> band = {-2 * series.pure_error_um,
                                    2 * series.pure_error_um};
  const ChartRange x = RangeOf({&all.at}, 0.02);
  const ChartRange y = RangeOf({&all.before_um, &all.after_um, &band}, 0.06);
  Chart chart({.x_label = scale.label,
               .y_label = ErrorLabel(series.channel),
               .x_min = x.min,
               .x_max = x.max,
               .y_min = y.min,
               .y_max = y.max});
  chart.Band(band[0], band[1], "2 sigma of a reading");
  const std::array inks = {Ink::kBefore, Ink::kThird, Ink::kDim};
  for (std::size_t part = 0; part < series.split_labels.size(); ++part) {
    const Pair rows = RowsOf(series, static_cast<int>(part), scale.unit);
    chart.Points(rows.at,
                 rows.before_um,
                 inks.at(part),
                 (part == 0 ? "before: " : "") + series.split_labels[part]);
  }
  if (series.split_labels.empty()) {
    chart.Points(all.at, all.before_um, Ink::kBefore, "before");
  }
  chart.Points(all.at, all.after_um, Ink::kAfter, "after");
  picture.svg = chart.Svg();
  return picture;
}

DiagnosisPicture ContrastPicture(const DirectionContrast& contrast) {
  const std::string axis = Letter(contrast.axis);
  DiagnosisPicture picture{
      .name = "direction_" + contrast.axis,
      .title = "Direction contrast of " + axis,
      .caption =
          "How much further forward than backward the axis stands at each position, "
          "the "
          "mean lost motion taken off. Level: the gap is the same everywhere. A bump: "
          "worn in one place. The band is two standard deviations of one difference."};
  const std::vector<double> band = {-2 * contrast.sd_um, 2 * contrast.sd_um};
  const ChartRange x = RangeOf({&contrast.at_mm}, 0.02);
  const ChartRange y = RangeOf({&contrast.before_um, &contrast.after_um, &band}, 0.1);
  Chart chart({.x_label = fmt::format("position along {} [mm]", axis),
               .y_label = "forward less backward [µm]",
               .x_min = x.min,
               .x_max = x.max,
               .y_min = y.min,
               .y_max = y.max});
  chart.Band(band[0], band[1], "2 sigma of a difference");
  chart.Points(contrast.at_mm, contrast.before_um, Ink::kBefore, "before");
  chart.Points(contrast.at_mm, contrast.after_um, Ink::kAfter, "after the findings");
  picture.svg = chart.Svg();
  return picture;
}

namespace {

// Shades the periods that cannot be told, and joins neighbours.
void ShadeHidden(const Periodogram& one, Chart* chart) {
  const std::size_t count = one.period_mm.size();
  for (std::size_t i = 0; i < count; ++i) {
    if (std::isfinite(one.before_um[i])) continue;
    std::size_t end = i;
    while (end + 1 < count && !std::isfinite(one.before_um[end + 1])) ++end;
    const double from = one.period_mm[i > 0 ? i - 1 : i];
    const double to = one.period_mm[end + 1 < count ? end + 1 : end];
    chart->Shade(from, to);
    i = end;
  }
}

// What the periods about four full steps hold, in a sentence.
std::string OfSteps(const Periodogram& one, std::size_t first) {
  double most_um = -1;
  for (std::size_t i = first; i < one.before_um.size(); ++i) {
    if (std::isfinite(one.before_um[i])) most_um = std::max(most_um, one.before_um[i]);
  }
  if (most_um < 0) {
    return fmt::format("Waves of four full steps ({:.3g} mm) cannot be told here.",
                       one.four_full_steps_mm);
  }
  return fmt::format("About four full steps ({:.3g} mm): {:.2g} µm at most.",
                     one.four_full_steps_mm,
                     most_um);
}

// The periods of turns alone.
Periodogram OfTurns(const Periodogram& one) {
  Periodogram turns = one;
  const std::size_t count = NumOfTurns(one);
  turns.period_mm.resize(count);
  turns.before_um.resize(count);
  turns.after_um.resize(count);
  return turns;
}

}  // namespace

DiagnosisPicture PeriodogramPicture(const Periodogram& all) {
  const std::string axis = Letter(all.axis);
  const std::string part = all.is_belt ? "pulley" : "screw";
  const Periodogram one = OfTurns(all);
  DiagnosisPicture picture{
      .name = "periodogram_" + one.axis,
      .title = fmt::format("Waves along {}", axis),
      .caption = fmt::format(
          "Amplitude of the wave of each period that fits the readings best beside the "
          "baseline and a bend; highest at {:.4g} mm. Grey: periods that these "
          "positions "
          "cannot tell from the baseline. Noise alone passes the dashed line in one of "
          "a "
          "hundred such pictures. {}",
          PeakPeriod_mm(one),
          OfSteps(all, one.period_mm.size()))};
  if (one.period_mm.size() < 2) return picture;
  const std::vector<double> top = {0, one.noise_um};
  const ChartRange y = RangeOf({&one.before_um, &one.after_um, &top}, 0.08);
  Chart chart({.x_label = "period [mm]",
               .y_label = "amplitude [µm]",
               .x_min = one.period_mm.back(),
               .x_max = one.period_mm.front(),
               .y_min = 0,
               .y_max = y.max,
               .is_log_x = true,
               .more_scales = {
                   {fmt::format("period [turns of the {}]", part), one.lead_mm},
                   {"period [four full steps of the motor]", one.four_full_steps_mm}}});
  ShadeHidden(one, &chart);
  chart.Vertical(one.lead_mm / 4, "1/4");
  chart.Vertical(one.lead_mm / 3, "1/3");
  chart.Vertical(one.lead_mm / 2, "1/2");
  chart.Vertical(one.lead_mm, "1 turn");
  chart.Line(one.period_mm, one.before_um, Ink::kBefore, "baseline alone");
  chart.Line(one.period_mm, one.after_um, Ink::kAfter, "with the findings");
  chart.Horizontal(one.noise_um, "noise, 99 %");
  picture.svg = chart.Svg();
  return picture;
}

std::vector<double> SharesInPercent(const Diagnosis& diagnosis) {
  std::vector<double> shares;
  for (const Finding& finding : diagnosis.findings) {
    shares.push_back(PercentFromFraction(finding.share));
  }
  constexpr double kWhole = 100;
  shares.push_back(kWhole - std::accumulate(shares.begin(), shares.end(), 0.0));
  return shares;
}

namespace {

// Findings without a name are told apart by what they depend on.
std::string NameWithCovariates(const Finding& finding) {
  const std::string name = NameInWords(finding.cause, finding.axis);
  if (finding.cause != "unknown") return name;
  return fmt::format("{} ({})", name, fmt::join(finding.covariates, ", "));
}

}  // namespace

DiagnosisPicture SharesPicture(const Diagnosis& diagnosis) {
  DiagnosisPicture picture{
      .name = "shares",
      .title = "What each cause contributes",
      .caption =
          "Parts of the variance, in rows left out in turn, that lies between the "
          "baseline alone and the noise floor (Shapley). They sum to 100 %."};
  if (diagnosis.findings.empty()) return picture;
  constexpr double kWidth = 760, kRow = 26, kLabels = 330, kNumbers = 70;
  const std::vector<double> shares = SharesInPercent(diagnosis);
  const double height = 12 + kRow * static_cast<double>(shares.size());
  std::string svg = SvgOpen(kWidth, height, picture.title);
  for (std::size_t i = 0; i < shares.size(); ++i) {
    const bool is_rest = i == diagnosis.findings.size();
    const std::string label =
        is_rest ? "remains unexplained" : NameWithCovariates(diagnosis.findings[i]);
    const double y = 6 + kRow * static_cast<double>(i);
    const double width =
        (kWidth - kLabels - kNumbers) * std::clamp(shares[i], 0.0, 100.0) / 100;
    svg += SvgText(kLabels - 10, y + 17, label, "end");
    svg += fmt::format(
        "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" {}/>\n",
        kLabels,
        y + 4,
        std::max(width, 1.0),
        kRow - 8,
        FillOf(is_rest ? Ink::kDim : Ink::kBefore));
    const double shown = std::round(10 * shares[i]) / 10 + 0.0;  // No "-0.0".
    svg +=
        SvgText(kLabels + width + 8, y + 17, fmt::format("{:.1f} %", shown), "start");
  }
  picture.svg = svg + "</svg>\n";
  return picture;
}

}  // namespace caltwin

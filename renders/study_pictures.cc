#include "renders/study_pictures.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "renders/chart.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kTwoSided95 = 1.959963984540054;

// The counts that a normal distribution of the stated sd would have.
ChartSeries Promised(const ParameterSummary& parameter) {
  const Histogram& h = parameter.histogram;
  const double part = (h.high - h.low) / static_cast<double>(h.counts.size());
  const double peak = static_cast<double>(parameter.coverage95.cases) * part /
                      (parameter.mean_sd * std::sqrt(2 * std::numbers::pi));
  ChartSeries curve{.label = "as stated", .is_line = true};
  constexpr int kPoints = 120;
  for (int i = 0; i <= kPoints; ++i) {
    const double error = std::lerp(h.low, h.high, i / double{kPoints});
    const double z = error / parameter.mean_sd;
    curve.x.push_back(error);
    curve.y.push_back(peak * std::exp(-z * z / 2));
  }
  return curve;
}

double HighestOf(const ParameterSummary& parameter) {
  const Histogram& h = parameter.histogram;
  double highest = static_cast<double>(*std::ranges::max_element(h.counts));
  if (parameter.mean_sd > 0) {
    const double part = (h.high - h.low) / static_cast<double>(h.counts.size());
    highest = std::max(highest,
                       static_cast<double>(parameter.coverage95.cases) * part /
                           (parameter.mean_sd * std::sqrt(2 * std::numbers::pi)));
  }
  return highest;
}

}  // namespace

std::string HistogramSvg(const ParameterSummary& parameter) {
  const Histogram& h = parameter.histogram;
  if (h.counts.empty()) return "";
  constexpr double kAir = 1.08;
  Chart chart(
      {.x_label = fmt::format("error of {} [{}]", parameter.name, parameter.unit),
       .y_label = "machines",
       .x_min = h.low,
       .x_max = h.high,
       .y_min = 0,
       .y_max = kAir * HighestOf(parameter)});
  const double part = (h.high - h.low) / static_cast<double>(h.counts.size());
  chart.Columns(h.low,
                part,
                {h.counts.begin(), h.counts.end()},
                Ink::kAfter,
                "errors of the machines");
  if (parameter.mean_sd > 0) {
    const ChartSeries curve = Promised(parameter);
    chart.Line(curve.x, curve.y, Ink::kBefore, curve.label);
    for (const double side : {-kTwoSided95, kTwoSided95}) {
      chart.Vertical(side * parameter.mean_sd,
                     fmt::format("{:+.2g}", side * parameter.mean_sd));
    }
  }
  return chart.Svg();
}

std::string CoverageSvg(const std::vector<ParameterSummary>& parameters) {
  constexpr double kRow = 22, kNames = 210, kWide = 760, kHead = 8, kFoot = 30;
  constexpr double kUsualLow = 0.90, kHigh = 1.0, kTick = 0.01;
  std::vector<const ParameterSummary*> stated;
  double low = kUsualLow;
  for (const ParameterSummary& one : parameters) {
    if (one.coverage95.cases == 0) continue;
    stated.push_back(&one);
    low = std::min(low, one.coverage95.rate - kTick);
  }
  if (stated.empty()) return "";
  const double bottom = kHead + kRow * static_cast<double>(stated.size());
  const auto x = [&](double rate) {
    return kNames +
           (std::clamp(rate, low, kHigh) - low) / (kHigh - low) * (kWide - kNames - 70);
  };
  std::string svg = SvgOpen(kWide, bottom + kFoot, "coverage of intervals of 95 %");
  svg += fmt::format(
      "<rect class=\"band\" fill=\"#dff3e6\" x=\"{:.1f}\" y=\"{}\" width=\"{:.1f}\" "
      "height=\"{}\"/>\n",
      x(0.93),
      kHead,
      x(0.97) - x(0.93),
      bottom - kHead);
  for (const double rate : NiceTicks(low, kHigh, 10)) {
    const std::string percent = fmt::format("{:.0f} %", PercentFromFraction(rate));
    svg += SvgText(x(rate), bottom + 16, percent, "middle", Ink::kDim, 11);
  }
  svg += fmt::format("<path d=\"M{:.1f} {}V{}\" stroke-dasharray=\"4 3\" {}/>\n",
                     x(0.95),
                     kHead,
                     bottom,
                     StrokeOf(Ink::kDim));
  double y = kHead + kRow / 2;
  for (const ParameterSummary* one : stated) {
    const Rate& rate = one->coverage95;
    svg += SvgText(kNames - 10, y + 4, one->name, "end");
    svg += fmt::format("<path d=\"M{:.1f} {}H{:.1f}\" stroke-width=\"1.6\" {}/>\n",
                       x(rate.low),
                       y,
                       x(rate.high),
                       StrokeOf(Ink::kAfter));
    svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"{}\" r=\"3.5\" {}/>\n",
                       x(rate.rate),
                       y,
                       FillOf(Ink::kAfter));
    svg += SvgText(
        kWide - 60, y + 4, fmt::format("{:.1f} %", PercentFromFraction(rate.rate)));
    y += kRow;
  }
  return svg + "</svg>\n";
}

}  // namespace caltwin

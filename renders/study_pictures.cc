#include "renders/study_pictures.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "renders/html.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kWidth = 420, kHeight = 210;
constexpr double kLeft = 12, kRight = 12, kTop = 26, kBottom = 34;
constexpr double kTwoSided95 = 1.959963984540054;

constexpr std::string_view kStyle =
    "<style>text{font:11px sans-serif;fill:#333}.bar{fill:#5b8fc7}.curve{fill:none;"
    "stroke:#c2571a;stroke-width:1.6}.mark{stroke:#c2571a;stroke-dasharray:4 3}"
    ".axis{stroke:#888}.band{fill:#dcebd8}.dot{fill:#24588f}.whisker{stroke:#24588f;"
    "stroke-width:1.6}.name{font-weight:bold}</style>";

std::string Begin(double width, double height, const std::string& title) {
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" role=\"img\" "
      "aria-label=\"{}\">{}<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
      width,
      height,
      Escaped(title),
      kStyle);
}

std::string Text(double x, double y, const char* anchor, const std::string& text) {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n",
                     x,
                     y,
                     anchor,
                     Escaped(text));
}

// From errors to the picture's width.
struct Across {
  double low = 0, high = 1;
  double operator()(double value) const {
    return kLeft + (value - low) / (high - low) * (kWidth - kLeft - kRight);
  }
};

// The counts that a normal distribution of the stated sd would have, as a path.
std::string Promised(const ParameterSummary& parameter,
                     const Across& across,
                     double per_count) {
  const Histogram& h = parameter.histogram;
  const double part = (h.high - h.low) / static_cast<double>(h.counts.size());
  const double peak = static_cast<double>(parameter.coverage95.cases) * part /
                      (parameter.mean_sd * std::sqrt(2 * std::numbers::pi));
  std::string path;
  constexpr int kPoints = 120;
  for (int i = 0; i <= kPoints; ++i) {
    const double error = std::lerp(h.low, h.high, i / double{kPoints});
    const double z = error / parameter.mean_sd;
    path += fmt::format("{}{:.1f} {:.1f}",
                        i == 0 ? "M" : " L",
                        across(error),
                        kHeight - kBottom - per_count * peak * std::exp(-z * z / 2));
  }
  return fmt::format("<path class=\"curve\" d=\"{}\"/>\n", path);
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
  const Across across{h.low, h.high};
  const double per_count = (kHeight - kTop - kBottom) / HighestOf(parameter);
  std::string svg = Begin(kWidth, kHeight, parameter.name + ": errors");
  const double part = (h.high - h.low) / static_cast<double>(h.counts.size());
  for (std::size_t i = 0; i < h.counts.size(); ++i) {
    const double from = across(h.low + part * static_cast<double>(i));
    const double height = per_count * static_cast<double>(h.counts[i]);
    svg += fmt::format(
        "<rect class=\"bar\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" "
        "height=\"{:.1f}\"/>\n",
        from,
        kHeight - kBottom - height,
        across(h.low + part) - across(h.low) - 0.6,
        height);
  }
  if (parameter.mean_sd > 0) {
    svg += Promised(parameter, across, per_count);
    for (const double side : {-kTwoSided95, kTwoSided95}) {
      const double x = across(side * parameter.mean_sd);
      svg += fmt::format(
          "<line class=\"mark\" x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1}\" "
          "y2=\"{2}\"/>\n",
          x,
          kTop,
          kHeight - kBottom);
      svg +=
          Text(x, kTop - 2, "middle", fmt::format("{:+.2g}", side * parameter.mean_sd));
    }
  }
  svg += fmt::format(
      "<line class=\"axis\" x1=\"{0}\" x2=\"{1}\" y1=\"{2}\" y2=\"{2}\"/>\n",
      kLeft,
      kWidth - kRight,
      kHeight - kBottom);
  svg += Text(kLeft, 12, "start", parameter.name);
  for (const double value : {h.low, 0.0, h.high}) {
    const char* anchor = value < 0 ? "start" : value > 0 ? "end" : "middle";
    svg += Text(
        across(value), kHeight - kBottom + 14, anchor, fmt::format("{:.2g}", value));
  }
  svg += Text(
      kWidth / 2,
      kHeight - 6,
      "middle",
      fmt::format("error [{}], {} machines", parameter.unit, parameter.error.count));
  return svg + "</svg>\n";
}

std::string CoverageSvg(const std::vector<ParameterSummary>& parameters) {
  constexpr double kRow = 20, kNames = 190, kWide = 640, kHead = 24;
  constexpr double kLow = 0.90, kHigh = 1.0;
  std::vector<const ParameterSummary*> stated;
  for (const ParameterSummary& one : parameters) {
    if (one.coverage95.cases > 0) stated.push_back(&one);
  }
  if (stated.empty()) return "";
  const double height = kHead + kRow * static_cast<double>(stated.size()) + 30;
  const auto x = [&](double rate) {
    return kNames + (std::clamp(rate, kLow, kHigh) - kLow) / (kHigh - kLow) *
                        (kWide - kNames - 70);
  };
  std::string svg = Begin(kWide, height, "coverage of intervals of 95 %");
  svg += fmt::format(
      "<rect class=\"band\" x=\"{:.1f}\" y=\"{}\" width=\"{:.1f}\" height=\"{}\"/>\n",
      x(0.93),
      kHead,
      x(0.97) - x(0.93),
      height - kHead - 30);
  for (const double rate : {0.90, 0.93, 0.95, 0.97, 1.0}) {
    svg += Text(x(rate),
                height - 14,
                "middle",
                fmt::format("{:.0f} %", PercentFromFraction(rate)));
  }
  svg += fmt::format(
      "<line class=\"mark\" x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1}\" y2=\"{2}\"/>\n",
      x(0.95),
      kHead,
      height - 30);
  svg +=
      Text(kNames, 14, "start", "truth within 1.96 stated sd; the band is 93 to 97 %");
  double y = kHead + kRow / 2;
  for (const ParameterSummary* one : stated) {
    const Rate& rate = one->coverage95;
    svg += Text(kNames - 10, y + 4, "end", one->name);
    svg += fmt::format(
        "<line class=\"whisker\" x1=\"{0:.1f}\" x2=\"{1:.1f}\" y1=\"{2}\" "
        "y2=\"{2}\"/>\n"
        "<circle class=\"dot\" cx=\"{3:.1f}\" cy=\"{2}\" r=\"3.5\"/>\n",
        x(rate.low),
        x(rate.high),
        y,
        x(rate.rate));
    svg += Text(kWide - 60,
                y + 4,
                "start",
                fmt::format("{:.1f} %", PercentFromFraction(rate.rate)));
    y += kRow;
  }
  return svg + "</svg>\n";
}

}  // namespace caltwin

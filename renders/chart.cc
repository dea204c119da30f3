#include "renders/chart.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include <fmt/format.h>

#include "renders/html.h"

namespace caltwin {
namespace {

constexpr double kWidth = 760, kPlotHeight = 250;
constexpr double kLeft = 62, kRight = 16, kTop = 46;
constexpr double kScaleHeight = 38;

struct InkLook {
  std::string_view name, colour;
};
constexpr std::size_t kNumSeries = 6;
constexpr std::array<InkLook, 9> kInks = {{{"before", "#c2500f"},
                                           {"after", "#1667b7"},
                                           {"third", "#1b7f4b"},
                                           {"fourth", "#8a3fb0"},
                                           {"fifth", "#8a7000"},
                                           {"sixth", "#b32558"},
                                           {"text", "#1b1e22"},
                                           {"dim", "#5c636b"},
                                           {"grid", "#dfe2e5"}}};

const InkLook& LookOf(Ink ink) {
  return kInks[static_cast<std::size_t>(ink)];
}

// Numbers of ticks: as many decimals as the step between them needs.
std::string TickText(double value, double step) {
  const int decimals =
      std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 6);
  return NumberText(value, std::pow(10.0, 1 - decimals) * 1.0001);
}

// 1, 2 and 5 times each power of ten, or powers alone where there are many.
std::vector<double> LogTicks(double min, double max) {
  const double decades = std::log10(max / min);
  const std::vector<double> steps =
      decades > 3 ? std::vector<double>{1} : std::vector<double>{1, 2, 5};
  std::vector<double> ticks;
  const int first = static_cast<int>(std::floor(std::log10(min)));
  const int last = static_cast<int>(std::floor(std::log10(max)));
  for (int exponent = first; exponent <= last; ++exponent) {
    for (const double step : steps) {
      const double tick = std::pow(10.0, exponent) * step;
      if (tick >= min * 0.9999 && tick <= max * 1.0001) ticks.push_back(tick);
    }
  }
  return ticks;
}

}  // namespace

Ink InkOfSeries(std::size_t index) {
  return static_cast<Ink>(index % kNumSeries);
}

ChartRange RangeOf(const std::vector<const std::vector<double>*>& all, double air) {
  double min = INFINITY, max = -INFINITY;
  for (const auto* values : all) {
    for (const double value : *values) {
      if (!std::isfinite(value)) continue;
      min = std::min(min, value);
      max = std::max(max, value);
    }
  }
  if (!(max >= min)) return {};
  const double more = max > min ? (max - min) * air : 1;
  return {min - more, max + more};
}

std::string FillOf(Ink ink) {
  return fmt::format(
      "class=\"fill-{}\" fill=\"{}\"", LookOf(ink).name, LookOf(ink).colour);
}

std::string StrokeOf(Ink ink) {
  return fmt::format("class=\"stroke-{}\" fill=\"none\" stroke=\"{}\"",
                     LookOf(ink).name,
                     LookOf(ink).colour);
}

double TextWidth(std::string_view text, double size) {
  constexpr double kMeanWidth = 0.61;  // Of a letter, by its size.
  std::size_t letters = 0;
  for (const char c : text) {
    if ((static_cast<unsigned char>(c) & 0xC0) != 0x80) ++letters;
  }
  return kMeanWidth * size * static_cast<double>(letters);
}

std::string SvgOpen(double width, double height, std::string_view title) {
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"drawn\" viewBox=\"0 0 {0:.0f} "
      "{1:.0f}\" width=\"{0:.0f}\" height=\"{1:.0f}\" role=\"img\" "
      "font-family=\"system-ui, 'Segoe UI', 'DejaVu Sans', sans-serif\">\n"
      "<title>{2}</title>\n<rect class=\"page\" width=\"100%\" height=\"100%\" "
      "fill=\"#ffffff\"/>\n",
      width,
      height,
      Escaped(title));
}

std::string SvgText(double x,
                    double y,
                    std::string_view text,
                    std::string_view anchor,
                    Ink ink,
                    double size) {
  return fmt::format(
      "<text x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"{:.1f}\" text-anchor=\"{}\" {}>{}"
      "</text>\n",
      x,
      y,
      size,
      anchor,
      FillOf(ink),
      Escaped(text));
}

std::vector<double> NiceTicks(double min, double max, int most) {
  if (!(max > min)) return {min};
  const double least = (max - min) / most;
  const double power = std::pow(10.0, std::floor(std::log10(least)));
  double step = power;
  for (const double factor : {1.0, 2.0, 5.0, 10.0}) {
    step = power * factor;
    if (step >= least * 0.9999) break;
  }
  std::vector<double> ticks;
  const auto first = std::llround(std::ceil(min / step - 1e-9));
  const auto last = std::llround(std::floor(max / step + 1e-9));
  for (auto i = first; i <= last; ++i) ticks.push_back(static_cast<double>(i) * step);
  return ticks;
}

Chart::Chart(ChartFrame frame) : frame_(std::move(frame)) {
  const auto num_scales = 1 + static_cast<double>(frame_.more_scales.size());
  height_ = kTop + kPlotHeight + kScaleHeight * num_scales + 6;
  legend_x_ = kLeft;
}

double Chart::X(double x) const {
  const double part =
      frame_.is_log_x
          ? std::log(x / frame_.x_min) / std::log(frame_.x_max / frame_.x_min)
          : (x - frame_.x_min) / (frame_.x_max - frame_.x_min);
  return kLeft + (kWidth - kLeft - kRight) * part;
}

double Chart::Y(double y) const {
  const double part = (y - frame_.y_min) / (frame_.y_max - frame_.y_min);
  return kTop + kPlotHeight * (1 - part);
}

void Chart::Entry(std::string_view mark, const std::string& label) {
  if (label.empty()) return;
  constexpr double kMarkWidth = 22, kGap = 18, kBaseline = 14, kRowHeight = 17;
  const double width = kMarkWidth + TextWidth(label);
  if (legend_x_ > kLeft && legend_x_ + width > kWidth) {
    legend_x_ = kLeft;
    legend_y_ += kRowHeight;
  }
  legend_ += fmt::format(
      "<g transform=\"translate({:.1f} {:.1f})\">{}</g>\n", legend_x_, legend_y_, mark);
  legend_ += SvgText(legend_x_ + kMarkWidth, legend_y_ + kBaseline, label);
  legend_x_ += width + kGap;
}

void Chart::Band(double y_from, double y_to, const std::string& label) {
  const double top = Y(std::min(y_to, frame_.y_max));
  const double bottom = Y(std::max(y_from, frame_.y_min));
  behind_ += fmt::format(
      "<rect class=\"band\" fill=\"#dff3e6\" x=\"{:.1f}\" y=\"{:.1f}\" "
      "width=\"{:.1f}\" height=\"{:.1f}\"/>\n",
      kLeft,
      top,
      kWidth - kLeft - kRight,
      bottom - top);
  Entry("<rect class=\"band\" fill=\"#dff3e6\" y=\"4\" width=\"16\" height=\"12\"/>",
        label);
}

void Chart::Shade(double x_from, double x_to) {
  const double left = std::min(X(x_from), X(x_to));
  const double right = std::max(X(x_from), X(x_to));
  behind_ += fmt::format(
      "<rect class=\"shade\" fill=\"#eceef0\" x=\"{:.1f}\" y=\"{:.1f}\" "
      "width=\"{:.1f}\" height=\"{:.1f}\"/>\n",
      left,
      kTop,
      std::max(right - left, 0.5),
      kPlotHeight);
}

void Chart::Points(const std::vector<double>& x,
                   const std::vector<double>& y,
                   Ink ink,
                   const std::string& label) {
  const double radius = x.size() > 400 ? 1.6 : 2.6;
  drawn_ += fmt::format("<g {} fill-opacity=\"0.75\">\n", FillOf(ink));
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (!std::isfinite(x[i]) || !std::isfinite(y[i])) continue;
    drawn_ += fmt::format(
        "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{}\"/>\n", X(x[i]), Y(y[i]), radius);
  }
  drawn_ += "</g>\n";
  Entry(fmt::format("<circle cx=\"9\" cy=\"10\" r=\"4\" {}/>", FillOf(ink)), label);
}

void Chart::Line(const std::vector<double>& x,
                 const std::vector<double>& y,
                 Ink ink,
                 const std::string& label) {
  std::string path;
  bool is_down = false;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const bool is_there = std::isfinite(x[i]) && std::isfinite(y[i]);
    if (is_there) {
      path += fmt::format("{}{:.1f} {:.1f}", is_down ? 'L' : 'M', X(x[i]), Y(y[i]));
    }
    is_down = is_there;
  }
  drawn_ += fmt::format(
      "<path d=\"{}\" stroke-width=\"1.4\" stroke-linejoin=\"round\" {}/>\n",
      path,
      StrokeOf(ink));
  Entry(fmt::format("<path d=\"M0 10H17\" stroke-width=\"2.4\" {}/>", StrokeOf(ink)),
        label);
}

void Chart::Columns(double x_from,
                    double width,
                    const std::vector<double>& heights,
                    Ink ink,
                    const std::string& label) {
  constexpr double kGap = 0.6;
  drawn_ += fmt::format("<g {} fill-opacity=\"0.75\">\n", FillOf(ink));
  double from = x_from;
  for (const double height : heights) {
    drawn_ += fmt::format(
        "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\"/>\n",
        X(from),
        Y(height),
        X(from + width) - X(from) - kGap,
        Y(0) - Y(height));
    from += width;
  }
  drawn_ += "</g>\n";
  Entry(fmt::format("<rect y=\"4\" width=\"16\" height=\"12\" {}/>", FillOf(ink)),
        label);
}

void Chart::Horizontal(double y, const std::string& label) {
  drawn_ +=
      fmt::format("<path d=\"M{:.1f} {:.1f}H{:.1f}\" stroke-dasharray=\"5 4\" {}/>\n",
                  kLeft,
                  Y(y),
                  kWidth - kRight,
                  StrokeOf(Ink::kDim));
  Entry(fmt::format("<path d=\"M0 10H17\" stroke-dasharray=\"5 4\" {}/>",
                    StrokeOf(Ink::kDim)),
        label);
}

void Chart::Vertical(double x, const std::string& label) {
  if (x < frame_.x_min || x > frame_.x_max) return;
  constexpr double kRowHeight = 11, kSize = 10.5;
  // Names that would overlap go to the next row.
  const double width = TextWidth(label, kSize) + 8;
  named_row_ = std::abs(X(x) - last_named_x_) < width ? 1 - named_row_ : 0;
  last_named_x_ = X(x);
  const double y = kTop - 4 - kRowHeight * named_row_;
  behind_ +=
      fmt::format("<path d=\"M{:.1f} {:.1f}V{:.1f}\" stroke-dasharray=\"2 3\" {}/>\n",
                  X(x),
                  y + 2,
                  kTop + kPlotHeight,
                  StrokeOf(Ink::kDim));
  const double half = TextWidth(label, kSize) / 2;
  const double at = std::clamp(X(x), kLeft + half, kWidth - kRight - half);
  behind_ += SvgText(at, y, label, "middle", Ink::kDim, kSize);
}

std::string Chart::Scale(const ExtraScale& scale, double top) const {
  const double min = frame_.x_min / scale.unit, max = frame_.x_max / scale.unit;
  const std::vector<double> ticks =
      frame_.is_log_x ? LogTicks(min, max) : NiceTicks(min, max, 10);
  std::string svg;
  double step = ticks.size() > 1 ? ticks[1] - ticks[0] : 1;
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    if (frame_.is_log_x) step = ticks[i];
    const double x = X(ticks[i] * scale.unit);
    svg +=
        fmt::format("<path d=\"M{:.1f} {:.1f}v4\" {}/>\n", x, top, StrokeOf(Ink::kDim));
    const std::string text =
        frame_.is_log_x ? fmt::format("{:.4g}", ticks[i]) : TickText(ticks[i], step);
    svg += SvgText(x, top + 15, text, "middle", Ink::kDim, 11);
  }
  svg += SvgText((kLeft + kWidth - kRight) / 2, top + 30, scale.label, "middle");
  return svg;
}

std::string Chart::Axes() const {
  std::string svg;
  const std::vector<double> ticks = NiceTicks(frame_.y_min, frame_.y_max, 6);
  const double step = ticks.size() > 1 ? ticks[1] - ticks[0] : 1;
  for (const double tick : ticks) {
    svg += fmt::format("<path d=\"M{:.1f} {:.1f}H{:.1f}\" {}/>\n",
                       kLeft,
                       Y(tick),
                       kWidth - kRight,
                       StrokeOf(tick == 0 ? Ink::kDim : Ink::kGrid));
    svg += SvgText(kLeft - 7, Y(tick) + 4, TickText(tick, step), "end", Ink::kDim, 11);
  }
  svg += fmt::format(
      "<text transform=\"translate(14 {:.1f}) rotate(-90)\" font-size=\"12\" "
      "text-anchor=\"middle\" {}>{}</text>\n",
      kTop + kPlotHeight / 2,
      FillOf(Ink::kText),
      Escaped(frame_.y_label));
  double top = kTop + kPlotHeight;
  svg += fmt::format("<path d=\"M{:.1f} {:.1f}H{:.1f}\" {}/>\n",
                     kLeft,
                     top,
                     kWidth - kRight,
                     StrokeOf(Ink::kDim));
  svg += Scale({frame_.x_label, 1}, top);
  for (const ExtraScale& scale : frame_.more_scales) {
    top += kScaleHeight;
    svg += Scale(scale, top);
  }
  return svg;
}

std::string Chart::Svg() const {
  return SvgOpen(kWidth, height_, frame_.y_label + " against " + frame_.x_label) +
         behind_ + Axes() + drawn_ + legend_ + "</svg>\n";
}

std::string ChartSvg(const std::string& x_label,
                     const std::string& y_label,
                     const std::vector<ChartSeries>& series) {
  constexpr double kAcross = 0.02, kUp = 0.08;
  std::vector<const std::vector<double>*> x, y;
  std::size_t num_points = 0;
  for (const ChartSeries& one : series) {
    x.push_back(&one.x);
    y.push_back(&one.y);
    num_points += one.x.size();
  }
  if (num_points == 0) return "";
  const ChartRange across = RangeOf(x, kAcross);
  const ChartRange up = RangeOf(y, kUp);
  Chart chart({.x_label = x_label,
               .y_label = y_label,
               .x_min = across.min,
               .x_max = across.max,
               .y_min = up.min,
               .y_max = up.max});
  for (std::size_t i = 0; i < series.size(); ++i) {
    const ChartSeries& one = series[i];
    const Ink ink = InkOfSeries(i);
    if (one.is_line) {
      chart.Line(one.x, one.y, ink, one.label);
    } else {
      chart.Points(one.x, one.y, ink, one.label);
    }
  }
  return chart.Svg();
}

}  // namespace caltwin

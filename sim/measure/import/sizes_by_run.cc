#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/units.h"
#include "sim/measure/import/fields.h"
#include "sim/measure/import/told_stories.h"

namespace caltwin {
namespace {

/// "Frame size: 2668.3 x 1579.1 mm".
struct Size {
  std::string label{};
  double width_mm = 0, height_mm = 0;
};

bool IsOfAGauge(const std::string& label) {
  constexpr std::array<std::string_view, 5> kWords = {
      "tape", "ruler", "calliper", "caliper", "by hand"};
  return std::ranges::any_of(kWords, [&](std::string_view word) {
    return label.find(word) != std::string::npos;
  });
}

// What stands before a colon or "=", where it speaks of a size; empty: nothing does.
std::string LabelOf(const std::string& lower) {
  constexpr std::array<std::string_view, 4> kWords = {
      "size", "frame", "area", "anchors"};
  const std::size_t end = lower.find_first_of(":=0123456789");
  if (end == std::string::npos || (lower[end] != ':' && lower[end] != '=')) return "";
  const std::string label = lower.substr(0, end);
  const bool is_size =
      IsOfAGauge(label) || std::ranges::any_of(kWords, [&](std::string_view word) {
        return label.find(word) != std::string::npos;
      });
  return is_size ? label : "";
}

std::optional<Size> SizeIn(const std::string& lower) {
  constexpr std::string_view kNumber = ".0123456789";
  for (std::size_t at = lower.find('x'); at != std::string::npos;
       at = lower.find('x', at + 1)) {
    const auto width_mm = NumberBefore(lower, at);
    std::size_t from = lower.find_first_not_of(' ', at + 1);
    const bool is_apart = at > 0 && lower[at - 1] == ' ' && from > at + 1;
    if (!width_mm || !is_apart || from == std::string::npos) continue;
    const auto height_mm =
        NumberOf(lower.substr(from, lower.find_first_not_of(kNumber, from) - from));
    if (!height_mm) continue;
    if (!height_mm || *width_mm <= 0 || *height_mm <= 0) continue;
    return Size{LabelOf(lower), *width_mm, *height_mm};
  }
  return std::nullopt;
}

/// The runs of one label, and what a gauge says.
struct Runs {
  std::vector<double> width_mm{}, height_mm{};
  std::optional<Size> gauge{};
};

// Of several results printed by each run the first, or the one like the gauge's.
Runs RunsIn(const std::string& text) {
  constexpr long kFewest = 3;
  constexpr double kAlike = 0.3;
  std::vector<Size> sizes;
  Runs runs;
  for (const TextLine& line : LinesOf(text)) {
    const auto size = SizeIn(Lowered(line.text));
    if (!size || size->label.empty()) continue;
    if (IsOfAGauge(size->label)) runs.gauge = size;
    if (!IsOfAGauge(size->label)) sizes.push_back(*size);
  }
  for (const Size& first : sizes) {
    const bool is_like =
        !runs.gauge || std::abs(first.width_mm / runs.gauge->width_mm - 1) < kAlike;
    if (!is_like || std::ranges::count(sizes, first.label, &Size::label) < kFewest) {
      continue;
    }
    for (const Size& size : sizes) {
      if (size.label != first.label) continue;
      runs.width_mm.push_back(size.width_mm);
      runs.height_mm.push_back(size.height_mm);
    }
    break;
  }
  return runs;
}

/// Largest less least, and as a share of the mean.
struct Spread {
  double least_mm = 0, most_mm = 0, share = 0;
};

Spread SpreadOf(const std::vector<double>& values_mm) {
  const auto [least, most] = std::ranges::minmax(values_mm);
  return {least, most, 2 * (most - least) / (most + least)};
}

double Correlation(const std::vector<double>& x, const std::vector<double>& y) {
  const auto num = static_cast<double>(x.size());
  double mean_x = 0, mean_y = 0, xy = 0, xx = 0, yy = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    mean_x += x[i] / num;
    mean_y += y[i] / num;
  }
  for (std::size_t i = 0; i < x.size(); ++i) {
    xy += (x[i] - mean_x) * (y[i] - mean_y);
    xx += std::pow(x[i] - mean_x, 2);
    yy += std::pow(y[i] - mean_y, 2);
  }
  return xx > 0 && yy > 0 ? xy / std::sqrt(xx * yy) : 0;
}

std::string SentenceOf(const Runs& runs, const Spread& width, const Spread& height) {
  constexpr double kTied = -0.8;
  const std::string gauge = runs.gauge
                                ? fmt::format(", where a tape says {:g} x {:g} mm",
                                              runs.gauge->width_mm,
                                              runs.gauge->height_mm)
                                : std::string();
  const std::string tied =
      Correlation(runs.width_mm, runs.height_mm) < kTied
          ? "Where the width comes out larger the height comes out smaller: the "
            "touched "
            "points lie too close to fix more than a mixture of both. "
          : "";
  return fmt::format(
      "{} runs find the frame {:g} to {:g} mm wide and {:g} to {:g} mm high{}: {:.0f} "
      "and {:.0f} mm apart, run after run of one frame. {}No run is to be taken for "
      "the "
      "frame, nor their mean{}",
      runs.width_mm.size(),
      width.least_mm,
      width.most_mm,
      height.least_mm,
      height.most_mm,
      gauge,
      width.most_mm - width.least_mm,
      height.most_mm - height.least_mm,
      tied,
      runs.gauge ? ": enter what the tape says, or calibrate by points further out"
                 : ": measure the frame with a tape, both ways, and enter that");
}

}  // namespace

std::optional<Imported> SizesByRunIn(const std::string& text) {
  constexpr double kApart = 0.01;
  const Runs runs = RunsIn(text);
  if (runs.width_mm.empty()) return std::nullopt;
  const Spread width = SpreadOf(runs.width_mm), height = SpreadOf(runs.height_mm);
  if (std::max(width.share, height.share) < kApart) return std::nullopt;
  Imported imported{
      .recognised = {fmt::format("{} results of a calibration's runs, and "
                                 "no readings",
                                 runs.width_mm.size())},
      .next_instrument = "tape",
      .next_sentence =
          "measure the frame with a tape, both ways and both "
          "diagonals"};
  for (const char axis : {'x', 'y'}) {
    imported.notes.push_back(
        {.kind = FileNote::Kind::kOpen,
         .what = fmt::format("scale.{}", axis),
         .sentence =
             fmt::format("steps/mm of {}: the runs differ by {:.1f} % themselves",
                         axis == 'x' ? 'X' : 'Y',
                         100 * (axis == 'x' ? width.share : height.share))});
  }
  imported.notes.push_back(
      {.kind = FileNote::Kind::kFact,
       .sentence = SentenceOf(runs, width, height),
       .fact = "contradiction",
       .word = "runs",
       .figures = {{"width_um", UmFromMm(width.most_mm - width.least_mm)},
                   {"height_um", UmFromMm(height.most_mm - height.least_mm)}}});
  return imported;
}

}  // namespace caltwin

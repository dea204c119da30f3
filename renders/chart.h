#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace caltwin {

/// Inks of a chart, by what they mean. Colours come with the drawing, so that it stands
/// alone as a file; a page may override them by class (its dark scheme does).
enum class Ink { kBefore, kAfter, kThird, kFourth, kFifth, kSixth, kText, kDim, kGrid };

/// The ink of the series `index`, which counts from 0: six, then again from the first.
Ink InkOfSeries(std::size_t index);

/// From the least to the most of what is drawn, with `air` of it at either end; never
/// empty. What is no number is not counted.
struct ChartRange {
  double min = 0, max = 1;
};
ChartRange RangeOf(const std::vector<const std::vector<double>*>& all, double air);

/// One more scale below a chart, for the same x in another unit: x / unit.
struct ExtraScale {
  std::string label{};
  double unit = 1;
};

struct ChartFrame {
  std::string x_label{};
  std::string y_label{};
  double x_min = 0, x_max = 1;
  double y_min = 0, y_max = 1;
  bool is_log_x = false;
  std::vector<ExtraScale> more_scales{};
};

/// A drawing of points and lines over axes, as SVG text that loads nothing. The same
/// calls give the same bytes. Points with a coordinate that is no number are skipped;
/// lines break there. Width and height are in pixels of the drawing, which scales.
class Chart {
 public:
  explicit Chart(ChartFrame frame);

  void Band(double y_from, double y_to, const std::string& label);
  void Shade(double x_from, double x_to);  ///< Where nothing can be told.
  void Points(const std::vector<double>& x,
              const std::vector<double>& y,
              Ink ink,
              const std::string& label);
  void Line(const std::vector<double>& x,
            const std::vector<double>& y,
            Ink ink,
            const std::string& label);
  /// Columns from 0 to `heights`, side by side from `x_from`, each `width` wide.
  void Columns(double x_from,
               double width,
               const std::vector<double>& heights,
               Ink ink,
               const std::string& label);
  void Horizontal(double y, const std::string& label);  ///< Dashed, across.
  void Vertical(double x, const std::string& label);    ///< Dashed, named at its top.

  std::string Svg() const;

 private:
  double X(double x) const;
  double Y(double y) const;
  void Entry(std::string_view mark, const std::string& label);
  std::string Axes() const;
  std::string Scale(const ExtraScale& scale, double top) const;

  ChartFrame frame_;
  double height_ = 0;
  std::string behind_{}, drawn_{}, legend_{};
  double legend_x_ = 0, legend_y_ = 0;
  double last_named_x_ = -1e9;
  int named_row_ = 0;
};

/// One set of points in a chart, or a line through them.
struct ChartSeries {
  std::string label{};
  std::vector<double> x{};
  std::vector<double> y{};
  bool is_line = false;
};

/// The series over axes that hold them all; empty where there is nothing to draw.
std::string ChartSvg(const std::string& x_label,
                     const std::string& y_label,
                     const std::vector<ChartSeries>& series);

/// @name Parts of drawings that are no charts.
/// `classes` are the ink's own; coordinates in pixels of the drawing.
std::string SvgOpen(double width, double height, std::string_view title);
std::string SvgText(double x,
                    double y,
                    std::string_view text,
                    std::string_view anchor = "start",
                    Ink ink = Ink::kText,
                    double size = 12);
/// `class="..." fill="#..."` (or stroke).
std::string FillOf(Ink ink);
std::string StrokeOf(Ink ink);
/// About how wide a text is drawn.
double TextWidth(std::string_view text, double size = 12);

/// Ticks at 1, 2 or 5 times powers of ten, at most `most`, inside the range.
std::vector<double> NiceTicks(double min, double max, int most);

}  // namespace caltwin

#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "sim/measure/import/console_line.h"

namespace caltwin {

/// A probed height of a printed mesh.
struct GridHeight {
  double x_mm = 0, y_mm = 0, height_mm = 0;
  int line = 0;
  bool has_place = true;  ///< False: x and y are indices.
};

/// The heights of "3 | +0.12 [-0.01] ." or of a line of numbers alone, kUnknown for
/// what was not probed; empty where the line is none.
std::vector<double> GridHeightsIn(std::string_view text);

/// Reads the mesh that Marlin prints (`G29 T`, `M420 V`), line by line: coordinates of
/// its upper corners, a row a line (`3 | +0.12 [-0.01] .`), coordinates of its lower
/// corners. A mesh without corners (`0 +0.059 +0.062`) has places by index.
class ConsoleGrid {
 public:
  /// Takes the line where it belongs to a mesh.
  bool Take(const ConsoleLine& line, int number);

  /// Whether the line begins another mesh: the numbers of the columns or of the rows
  /// begin anew.
  bool EndsBefore(const ConsoleLine& line) const;

  /// A mesh begins there whose heights say so by themselves.
  void Begin(int number) {
    if (lost_line_ == 0) lost_line_ = number;
  }

  /// Whether a mesh is whole; then its heights, and the next may begin.
  bool is_whole() const { return is_whole_; }
  /// Ends a mesh without corners.
  void End() { is_whole_ |= lost_line_ > 0 && rows_.size() >= 2; }
  std::vector<GridHeight> TakeHeights();

  /// The line of a mesh whose corners never came; 0: none.
  int line_without_corners() const { return lost_line_; }

 private:
  using Corners = std::pair<std::pair<double, double>, std::pair<double, double>>;
  static std::optional<Corners> CornersOf(const ConsoleLine& line);

  std::optional<Corners> upper_{}, lower_{};
  std::vector<std::pair<int, std::vector<double>>> rows_{};  ///< Line; kUnknown: none.
  bool is_whole_ = false;
  bool is_numbered_ = false;  ///< Rows begin with their number.
  int lost_line_ = 0;
};

}  // namespace caltwin

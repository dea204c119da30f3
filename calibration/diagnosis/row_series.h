#pragma once

#include <string>
#include <vector>

#include "sim/measure/row.h"

namespace caltwin {

/// Rows that one straight line should fit: same campaign, kind, setup, feature and
/// normal.
struct RowSeries {
  const Row* first = nullptr;
  std::vector<const Row*> rows{};
};

std::vector<RowSeries> SeriesOf(const RowTable& table);

/// Row::cmd_mm along its normal; an axis that is unknown counts as 0.
double AlongNormal_mm(const Row& row);
/// Sense of the last approach along the normal: 1, -1, or 0 where unknown or sideways.
double SenseAlongNormal(const Row& row);

/// Value = offset + slope . cmd + half_gap * sense, by least squares, fitted twice: the
/// second time without what lies beyond five times the median residual.
struct SeriesFit {
  double slope = 0;  ///< Of the value along the normal; 0: positions do not differ.
  double half_gap_mm = 0;  ///< Mean forward minus mean backward, halved; 0: one sense.
  double half_gap_sd_mm = 0;
  double size_mm = 0;  ///< 1.48 median residuals: the residual's standard deviation.
};
SeriesFit FitSeries(const RowSeries& series);

/// Standard deviation of readings repeated at one pose in one sense, over all series;
/// kUnknown where none is repeated three times or more.
double RepeatDeviation_mm(const std::vector<RowSeries>& all);

}  // namespace caltwin

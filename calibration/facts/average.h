#pragma once

#include <cmath>
#include <vector>

#include "sim/measure/row.h"

namespace caltwin {

/// Mean and standard deviation of a few values.
struct Average {
  double mean = 0;
  double sd = kUnknown;  ///< kUnknown of fewer than two.
  double num = 0;
};

inline Average AverageOf(const std::vector<double>& values) {
  Average average{.num = static_cast<double>(values.size())};
  for (const double value : values) average.mean += value / average.num;
  if (values.size() < 2) return average;
  average.sd = 0;
  for (const double value : values) average.sd += std::pow(value - average.mean, 2);
  average.sd = std::sqrt(average.sd / (average.num - 1));
  return average;
}

/// Of the readings of rows.
inline Average AverageOf(const std::vector<const Row*>& rows) {
  std::vector<double> values_mm;
  for (const Row* row : rows) values_mm.push_back(row->value_mm);
  return AverageOf(values_mm);
}

}  // namespace caltwin

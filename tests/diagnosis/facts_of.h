#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "calibration/facts/fact.h"

namespace caltwin {

/// The facts of rows, numbered in their order from 1.
inline Facts FactsOfRows(std::vector<Row> rows,
                         const DataHeader& header = {},
                         const LevellingLog& log = {}) {
  RowTable table{.rows = std::move(rows)};
  std::int64_t number = 0;
  for (Row& row : table.rows) row.row = ++number;
  return FactsOf(table, header, log);
}

/// A figure of a fact; kUnknown: it has none of that name.
inline double FigureOf(const Fact& fact, const std::string& key) {
  for (const FactFigure& figure : fact.figures) {
    if (figure.key == key) return figure.value;
  }
  return kUnknown;
}

}  // namespace caltwin

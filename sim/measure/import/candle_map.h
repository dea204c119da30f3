#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/measure/import/import.h"

namespace caltwin {

/// A height map as Candle saves it, semicolons between numbers:
///
///   x;y;width;height
///   columns;rows;Z from;Z to
///   interpolation;step;step
///   heights, a line a row
struct CandleMap {
  double x_mm = 0, y_mm = 0, width_mm = 0, height_mm = 0;
  std::vector<std::vector<double>> heights_mm{};
  int line = 0;  ///< Of its first line.

  /// Whether every height is the same to the last digit, as no probe reads.
  bool IsLevel() const;
  std::size_t num() const;
};

/// The first such map of a text, whatever stands around it; nullopt: none.
std::optional<CandleMap> CandleMapIn(const std::string& text);

/// A note where a map is level to the last digit: of a program that wrote something
/// else than what was touched. `touched_mm`: heights that a console shows beside it.
void TellLevelMap(const CandleMap& map,
                  const std::vector<double>& touched_mm,
                  Imported* imported);

/// Reads a map as touches of a board. Throws InputError where none stands there.
Imported ReadCandleMap(const std::string& text,
                       const std::string& name,
                       const ImportOptions& options);

}  // namespace caltwin

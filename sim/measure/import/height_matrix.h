#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/measure/import/import.h"

namespace caltwin {

/// Heights as a sheet has them, x across and y down, the places beside them:
///
///   X:       -80    0     80
///   y:  80  12.45  12.79  13.48
///   y:   0  12.91  12.63  13.00
///   y: -80  13.61  12.95  12.29
struct HeightMatrix {
  std::vector<double> x_mm{}, y_mm{};
  std::vector<std::vector<double>> heights_mm{};  ///< A line for each y.
  int line = 0;                                   ///< Of the places along x.
};

/// The first such matrix of a text, whatever stands around it: three or more evenly
/// spaced places each way, and a number for each. nullopt: none.
std::optional<HeightMatrix> HeightMatrixIn(const std::string& text);

/// Reads a matrix as touches of a bed. Throws InputError where none stands there.
Imported ReadHeightMatrix(const std::string& text,
                          const std::string& name,
                          const ImportOptions& options);

}  // namespace caltwin

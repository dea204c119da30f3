#pragma once

#include <array>
#include <string>
#include <vector>

#include "sim/measure/import/import.h"

namespace caltwin {

/// Differences of three screws as Marlin's G34 prints them, an iteration a line:
/// "Z2-Z1=7.29 Z3-Z2=7.37 Z3-Z1=14.65". Without signs.
class ScrewDifferences {
 public:
  /// Takes the line where it holds all three.
  bool Take(const std::string& lower);

  /// A note of a screw that does not follow its correction: the differences with it
  /// stay, the one without it goes.
  void Tell(Imported* imported) const;

 private:
  /// Of screws 1 and 2, 2 and 3, 1 and 3.
  std::vector<std::array<double, 3>> rounds_mm_{};
};

}  // namespace caltwin

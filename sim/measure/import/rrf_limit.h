#pragma once

#include <array>
#include <vector>

#include "sim/measure/import/console_line.h"
#include "sim/measure/import/import.h"

namespace caltwin {

/// A levelling that RepRapFirmware refused, because one of the motors would have had to
/// move further than M671 allows: "Some computed corrections exceed configured limit of
/// 1.00mm: -0.737 -1.543"; and one that fits its points whatever they are.
class CorrectionLimit {
 public:
  /// `line`: its number in the file.
  void Take(const ConsoleLine& said, int line);
  void Tell(Imported* imported) const;

 private:
  std::vector<std::array<double, 2>> points_mm_{};  ///< Of G30 Pn.
  std::vector<double> corrections_mm_{};
  double limit_mm_ = kUnknown;
  int line_ = 0;
  bool fits_exactly_ = false;  ///< As many points as motors.
};

}  // namespace caltwin

#pragma once

#include <array>
#include <vector>

#include "sim/measure/import/console_line.h"
#include "sim/measure/import/import.h"

namespace caltwin {

/// Steps/mm as set against those that pulley, belt, motor and microsteps need:
///
///   steps/mm = 360 / (degrees a step) x microsteps / (teeth x pitch)
///
/// A factor of two, four ... between them is microsteps that were changed on one side
/// alone.
class DriveSteps {
 public:
  void Take(const ConsoleLine& line, int number);
  void Tell(Imported* imported) const;

 private:
  double Needed(double microsteps) const;

  std::array<double, 2> set_{kUnknown, kUnknown};  ///< M92 X Y.
  double teeth_ = kUnknown, pitch_mm_ = kUnknown, step_deg_ = kUnknown;
  double microsteps_ = kUnknown;     ///< Of the driver, as a setting says.
  std::vector<double> spoken_of_{};  ///< Other microsteps in the remarks.
  int line_ = 0;                     ///< Of the M92.
};

}  // namespace caltwin

#pragma once

#include "sim/measure/import/console_line.h"
#include "sim/measure/import/import.h"

namespace caltwin {

/// Steps/mm of Z that were set (`M92 Z393.51`) between two maps of a bed: every height
/// counts anew from where Z homes, and the maps differ by a constant.
class StepsBetween {
 public:
  /// `line`: its number in the file. `is_report`: the firmware said what is set.
  void Take(const ConsoleLine& said, int line, bool is_report);
  /// After the rows are read.
  void Tell(Imported* imported) const;

 private:
  double before_ = kUnknown, set_ = kUnknown;  ///< Steps/mm.
  int line_ = 0;
};

}  // namespace caltwin

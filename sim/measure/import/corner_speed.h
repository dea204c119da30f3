#pragma once

#include "sim/measure/import/console_line.h"
#include "sim/measure/import/import.h"

namespace caltwin {

/// Whether grbl slows down at corners: $11, the junction deviation d, and the
/// acceleration a ($120) give the speed at which a right angle is taken,
///
///   v = sqrt(a d s / (1 - s)),   s = sin 45 deg
///
/// Some hundredths of a millimetre are usual; millimetres mean that the axis is stopped
/// at full speed, and loses steps.
class CornerSpeed {
 public:
  void Take(const ConsoleLine& line);
  void Tell(Imported* imported) const;

 private:
  double deviation_mm_ = kUnknown;
  double acceleration_mm_s2_ = kUnknown;
  double most_mm_min_ = kUnknown;  ///< $110.
  bool is_old_ = false;            ///< grbl 0.8, where $11 is no such thing.
};

}  // namespace caltwin

#pragma once

#include <array>

#include "sim/measure/import/console_line.h"
#include "sim/measure/import/import.h"

namespace caltwin {

/// A work offset that a macro set to where a touch was told to end, not to where it
/// touched: the sender read the position before the touch was over. Of grbl ("[PRB:")
/// and TinyG ("{"r":{"prb":{"e":1,...").
class TouchOffset {
 public:
  /// `line`: its number in the file.
  void Take(const ConsoleLine& said, int line);
  void Tell(Imported* imported) const;

 private:
  double target_mm_ = kUnknown;  ///< Z of the last G38.
  double touch_mm_ = kUnknown;   ///< Z of the last touch.
  double set_mm_ = kUnknown;     ///< Z of G10 L2.
  int line_ = 0;                 ///< Of G10 L2.
};

/// Where a touch of TinyG was, "{"r":{"prb":{"e":1,"x":20.0,...": x, y, z; nullopt: the
/// line is none, or it found nothing.
std::optional<std::array<double, 3>> TouchOfTinyG(const ConsoleLine& said);

/// Where a probing of grbl ended, of as many axes as it has
/// "[PRB:1.000,2.000,-3.000,0.000:1]".
struct GrblTouch {
  std::array<double, 3> at_mm{};
  bool has_touched = false;
};
std::optional<GrblTouch> TouchOfGrbl(const ConsoleLine& said);

}  // namespace caltwin

#pragma once

#include <map>

#include "sim/measure/import/console_line.h"
#include "sim/measure/import/import.h"

namespace caltwin {

/// Moves that a controller of the TinyG family (g2) was told, and where it says itself
/// that they ended ("G1A2.0 ...", "{"sr":{"posa":0.079,...,"stat":3}}"). Where that is
/// 25.4 times less or more, inches and millimetres were mixed, and no motor is to
/// blame: the position is the controller's own count. Where none of several axes went
/// where it was told, the unit of the program is another, and nothing is said.
class ReportedMove {
 public:
  void Take(const ConsoleLine& line);
  void Tell(Imported* imported) const;

 private:
  struct Ended {
    double told = 0, reported = 0;
  };
  std::map<char, double> told_{};      ///< By axis, of the last move.
  std::map<char, double> reported_{};  ///< Last position of each axis.
  std::map<char, Ended> ended_{};      ///< By axis, the last move that ended.
  bool is_in_inches_ = false;          ///< G20: told in inches, reported in mm.
};

}  // namespace caltwin

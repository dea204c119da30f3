#pragma once

#include <string>

namespace caltwin {

/// What the text around a table says of all its readings.
struct TableRemarks {
  double step_mm = 0;          ///< Whole numbers count steps of this length; 0: none.
  bool is_homed = false;       ///< Before every reading.
  bool are_distances = false;  ///< Of centres.
  bool define_lost_motion = false;  ///< What a dial read: "lost motion = ...".
  bool are_in_inches = false;       ///< "Everything in inches".
};
TableRemarks RemarksIn(const std::string& text);

}  // namespace caltwin

#pragma once

#include <string>
#include <vector>

namespace caltwin {

/// What a ratio of moved to commanded is, where it is one that people know.
struct KnownRatio {
  std::string reading{};  ///< microsteps inches diameter_radius lead sign unit
  std::vector<std::string> also{};  ///< Others that give the same ratio.
  bool has_rival = false;  ///< Another reading is as near, and no figure parts them.
  std::string sentence{};  ///< What a person needs; no full stop.
};

/// Of an axis that moves `factor` times what is commanded, known to `sd`. Empty
/// reading: the ratio is none that is known (or so near to 1 that it is a calibration).
KnownRatio KnownRatioOf(double factor, double sd);

}  // namespace caltwin

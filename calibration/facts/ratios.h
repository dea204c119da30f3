#pragma once

#include <string>
#include <string_view>
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

/// A ratio near to 1 that something other than a drive makes.
struct FineRatio {
  double ratio = 1;
  std::string_view reading{};   ///< encoder_lines pixels_per_inch; empty: none.
  std::string_view sentence{};  ///< No full stop.
};

/// Of a factor that is within 12 % of 1: one that is known, or its inverse, to half a
/// thousandth; none where the factor is known less well than that.
FineRatio FineRatioOf(double factor, double sd);

}  // namespace caltwin

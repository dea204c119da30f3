#pragma once

#include <string>
#include <string_view>

namespace caltwin {

/// A value with its standard uncertainty, to the digit that the uncertainty carries:
/// "5.6 +- 0.2 um". Without one (NaN or 0): three digits, "5.63 um".
std::string WithSd(double value, double sd, std::string_view unit);

/// To two digits and never in powers of ten: "0.37", "15", "1300".
std::string TwoDigits(double value);

}  // namespace caltwin

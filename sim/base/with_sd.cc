#include "sim/base/with_sd.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace caltwin {

std::string WithSd(double value, double sd, std::string_view unit) {
  const std::string gap = unit.empty() ? "" : " ";
  constexpr int kMostDecimals = 6;
  if (!std::isfinite(sd) || sd <= 0) {
    const int digits =
        value == 0 ? 0 : 2 - static_cast<int>(std::floor(std::log10(std::abs(value))));
    return fmt::format(
        "{:.{}f}{}{}", value, std::clamp(digits, 0, kMostDecimals), gap, unit);
  }
  // An uncertainty that rounds up to the next power of ten has one decimal less.
  const double rounded = std::stod(fmt::format("{:.0e}", sd));
  const int decimals = -static_cast<int>(std::floor(std::log10(rounded) + 1e-9));
  const int shown = std::clamp(decimals, 0, kMostDecimals);
  // "-0.000" says a sign that the digits do not have.
  const bool is_zero = std::abs(value) < std::pow(10.0, -shown) / 2;
  const double told = is_zero ? 0 : value;
  return fmt::format("{:.{}f} +- {:.{}f}{}{}", told, shown, sd, shown, gap, unit);
}

std::string TwoDigits(double value) {
  constexpr double kWhole = 99.5, kNothing = 1e-9;
  if (std::abs(value) < kNothing) return "0";
  if (!(std::abs(value) >= kWhole)) return fmt::format("{:.2g}", value);
  const double unit = std::pow(10.0, std::floor(std::log10(std::abs(value))) - 1);
  return fmt::format("{:.0f}", std::round(value / unit) * unit);
}

}  // namespace caltwin

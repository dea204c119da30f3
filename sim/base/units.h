#pragma once

/// Conversions between what files say (um, mrad, ppm, ms, deg) and what code uses (mm,
/// rad, s). The only place, beside `sim/mjcf` and `sim/physics` (m) and
/// `sim/link/gcode.cc` (mm/min), where such factors stand. Templated on the scalar, so
/// that automatic derivatives pass through.

#include <numbers>

namespace caltwin {

template <typename T>
constexpr T MmFromUm(const T& um) {
  return um * 1e-3;
}
template <typename T>
constexpr T UmFromMm(const T& mm) {
  return mm * 1e3;
}
template <typename T>
constexpr T RadFromMrad(const T& mrad) {
  return mrad * 1e-3;
}
template <typename T>
constexpr T RadFromUrad(const T& urad) {
  return urad * 1e-6;
}
template <typename T>
constexpr T MradFromRad(const T& rad) {
  return rad * 1e3;
}
template <typename T>
constexpr T RadFromDeg(const T& deg) {
  return deg * (std::numbers::pi / 180);
}
template <typename T>
constexpr T DegFromRad(const T& rad) {
  return rad * (180 / std::numbers::pi);
}
template <typename T>
constexpr T SFromMs(const T& ms) {
  return ms * 1e-3;
}
template <typename T>
constexpr T FractionFromPpm(const T& ppm) {
  return ppm * 1e-6;
}
template <typename T>
constexpr T PpmFromFraction(const T& fraction) {
  return fraction * 1e6;
}
template <typename T>
constexpr T PercentFromFraction(const T& fraction) {
  return fraction * 1e2;
}

}  // namespace caltwin

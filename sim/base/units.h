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

template <typename T>
constexpr T MmFromNm(const T& nm) {
  return nm * 1e-6;
}
template <typename T>
constexpr T MmFromM(const T& m) {
  return m * 1e3;
}
template <typename T>
constexpr T MmFromInch(const T& inch) {
  return inch * 25.4;
}
/// A thousandth of an inch: thou, in America mil.
template <typename T>
constexpr T MmFromThou(const T& thou) {
  return thou * 25.4e-3;
}
template <typename T>
constexpr T SFromMin(const T& min) {
  return min * 60;
}
template <typename T>
constexpr T SFromH(const T& h) {
  return h * 3600;
}
/// A feed, of G-code (mm/min) or of a drive.
template <typename T>
constexpr T MmPerSFromMmPerMin(const T& mm_min) {
  return mm_min / 60;
}
template <typename T>
constexpr T MmPerSFromMPerMin(const T& m_min) {
  return m_min * 1e3 / 60;
}
template <typename T>
constexpr T MmPerSFromMPerS(const T& m_s) {
  return m_s * 1e3;
}
template <typename T>
constexpr T MmPerSFromInchPerMin(const T& inch_min) {
  return inch_min * 25.4 / 60;
}
template <typename T>
constexpr T NFromKN(const T& kn) {
  return kn * 1e3;
}
template <typename T>
constexpr T NFromKgf(const T& kgf) {
  return kgf * 9.80665;
}
template <typename T>
constexpr T NFromLbf(const T& lbf) {
  return lbf * 4.4482216152605;
}
template <typename T>
constexpr T CelsiusFromKelvin(const T& kelvin) {
  return kelvin - 273.15;
}
template <typename T>
constexpr T CelsiusFromFahrenheit(const T& fahrenheit) {
  return (fahrenheit - 32) / 1.8;
}

}  // namespace caltwin

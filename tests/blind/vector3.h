#pragma once

#include <array>
#include <cmath>

namespace blind {

/// Three numbers along the machine's x, y, z. The truth code has its own algebra: it
/// shares nothing with the simulation that it is the test of.
using Vector3 = std::array<double, 3>;

inline Vector3 operator+(const Vector3& a, const Vector3& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
inline Vector3 operator-(const Vector3& a, const Vector3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Vector3 operator*(double k, const Vector3& a) {
  return {k * a[0], k * a[1], k * a[2]};
}
inline double Dot(const Vector3& a, const Vector3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline Vector3 Cross(const Vector3& a, const Vector3& b) {
  return {
      a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline double Norm(const Vector3& a) {
  return std::sqrt(Dot(a, a));
}
/// Turned about z by `angle_rad`, counter-clockwise from above.
inline Vector3 TurnedAboutZ(const Vector3& a, double angle_rad) {
  const double c = std::cos(angle_rad);
  const double s = std::sin(angle_rad);
  return {c * a[0] - s * a[1], s * a[0] + c * a[1], a[2]};
}
/// Unit vector of axis 0, 1 or 2, times `sign`.
inline Vector3 Along(int axis, double sign = 1) {
  Vector3 v{};
  v[static_cast<std::size_t>(axis)] = sign;
  return v;
}

}  // namespace blind

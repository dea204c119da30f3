#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include <Eigen/Core>

namespace caltwin {

/// A linear axis of a cartesian machine; the number is its index in every array of
/// three.
enum class Axis { kX = 0, kY = 1, kZ = 2 };

inline constexpr std::array<Axis, 3> kAxes = {Axis::kX, Axis::kY, Axis::kZ};

constexpr int Index(Axis axis) {
  return static_cast<int>(axis);
}
constexpr char Letter(Axis axis) {
  return "xyz"[Index(axis)];
}
constexpr char CapitalLetter(Axis axis) {
  return "XYZ"[Index(axis)];
}
inline std::string Name(Axis axis) {
  return std::string(1, Letter(axis));
}

/// "x", "y" or "z"; nullopt for anything else.
constexpr std::optional<Axis> AxisNamed(std::string_view name) {
  for (const Axis axis : kAxes) {
    if (name.size() == 1 && name[0] == Letter(axis)) return axis;
  }
  return std::nullopt;
}

template <typename T>
using Vec3 = Eigen::Matrix<T, 3, 1>;

inline Vec3<double> Unit(Axis axis) {
  return Vec3<double>::Unit(Index(axis));
}

}  // namespace caltwin

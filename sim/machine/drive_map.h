#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "sim/machine/axis.h"

namespace caltwin {

/// Where drives move the axes together, by a linear map: the two belts of a CoreXY.
/// Everything that belongs to a drive (steps/mm, play, waves) then has the drive's
/// index in arrays of three and is called by the drive's name.
///
/// Functions of this header take null for a machine whose axes are its drives.
struct DriveMap {
  std::array<std::string_view, 3> names{};  ///< "a", "b", "z".
  /// A column a drive: what one millimetre of it moves the axes.
  Eigen::Matrix3d axes_by_drive = Eigen::Matrix3d::Identity();
  /// Its inverse; a row a drive.
  Eigen::Matrix3d drives_by_axis = Eigen::Matrix3d::Identity();

  /// Whether more than the axis of its index turns the drive: its row of
  /// drives_by_axis. (What it moves is its column of axes_by_drive.)
  bool is_coupled(int drive) const {
    return drives_by_axis.row(drive) != Eigen::Matrix3d::Identity().row(drive);
  }
};

/// What the axes do where the drives do this [mm, or mm/s].
inline Vec3<double> AxesOf(const DriveMap* map, const Vec3<double>& drives) {
  return map == nullptr ? drives : Vec3<double>(map->axes_by_drive * drives);
}
/// What the drives have to do for that.
inline Vec3<double> DrivesOf(const DriveMap* map, const Vec3<double>& axes) {
  return map == nullptr ? axes : Vec3<double>(map->drives_by_axis * axes);
}

inline std::string DriveName(const DriveMap* map, int drive) {
  const auto k = static_cast<std::size_t>(drive);
  return map == nullptr ? Name(kAxes[k]) : std::string(map->names[k]);
}
/// nullopt: there is no such drive.
inline std::optional<int> DriveIndex(const DriveMap* map, std::string_view name) {
  for (int i = 0; i < 3; ++i) {
    if (DriveName(map, i) == name) return i;
  }
  return std::nullopt;
}

}  // namespace caltwin

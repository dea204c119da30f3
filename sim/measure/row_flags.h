#pragma once

#include <algorithm>
#include <array>
#include <string_view>

namespace caltwin {

/// @name What a reader or a procedure writes into a row's flag: what kind of reading it
/// is
inline constexpr std::string_view kMoveFlag = "move";          ///< How far a move went.
inline constexpr std::string_view kDistanceFlag = "distance";  ///< Of two centres.
inline constexpr std::string_view kLengthFlag = "length";      ///< In a plane.
inline constexpr std::string_view kLostMotionFlag = "lost_motion";
inline constexpr std::string_view kSidesFlag = "sides";  ///< One side of two.
inline constexpr std::string_view kReleaseFlag = "release";
inline constexpr std::string_view kAfterFlag = "after ";  ///< What stood before it.

/// Whether a flag says what kind of reading a row is; else it is somebody's remark,
/// that something may be wrong with it.
inline bool IsKindOfReading(std::string_view flag) {
  constexpr std::array kAll = {
      kMoveFlag, kDistanceFlag, kLengthFlag, kLostMotionFlag, kSidesFlag, kReleaseFlag};
  return flag.starts_with(kAfterFlag) || std::ranges::find(kAll, flag) != kAll.end();
}

}  // namespace caltwin

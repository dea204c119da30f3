#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace caltwin {

/// A line of G-code out of its frame: what stands around its words, which are not read.
struct GcodeFrame {
  std::optional<int> number{};  ///< N...
  std::string text{};           ///< Without number, checksum and comment.
};

/// Takes off number and checksum, which must be right. A wire does no more: what words
/// mean is the controller's affair (the lists of `M584 Z0:1:2`). Throws InputError,
/// with the column, for a wrong checksum and for what is no text.
GcodeFrame ReadGcodeFrame(std::string_view line);

}  // namespace caltwin

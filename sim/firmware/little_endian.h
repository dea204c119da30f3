#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace caltwin {

/// Writes `size` bytes of `value`, the least significant first.
inline void PutLittle(std::uint64_t value, std::span<std::uint8_t> to) {
  for (std::uint8_t& byte : to) {
    byte = static_cast<std::uint8_t>(value & 0xFFU);
    value >>= 8U;
  }
}

/// The number of those bytes, the least significant first.
inline std::uint64_t GetLittle(std::span<const std::uint8_t> from) {
  std::uint64_t value = 0;
  for (std::size_t i = from.size(); i-- > 0;) value = (value << 8U) | from[i];
  return value;
}

}  // namespace caltwin

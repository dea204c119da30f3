#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "sim/base/rng.h"

namespace caltwin {

/// Two sectors of NOR flash, as a controller keeps settings in: programming clears bits
/// byte by byte, only erasing a whole sector sets them again.
///
/// The power may be cut: after so many bytes the byte in hand is left half done, as are
/// those behind it that a page buffer had taken already, and everything later is
/// refused. An erased byte counts as a byte.
class Flash {
 public:
  static constexpr std::size_t kSectors = 2;
  static constexpr std::size_t kSectorBytes = 8192;
  static constexpr std::uint8_t kErased = 0xFF;

  Flash() : bytes_(kSectors * kSectorBytes, kErased) {}

  /// @return false: the power went
  bool Program(std::size_t at, std::span<const std::uint8_t> bytes);
  bool Erase(std::size_t sector);

  std::span<const std::uint8_t> Read(std::size_t at, std::size_t size) const {
    return std::span(bytes_).subspan(at, size);
  }

  /// Cuts the power once so many bytes more are done; `rng` (borrowed) leaves its marks
  /// on what was in hand.
  void CutAfter(std::uint64_t bytes, Rng* rng) {
    left_ = bytes;
    rng_ = rng;
  }
  void PowerUp() { left_.reset(); }
  /// Bytes programmed or erased so far.
  std::uint64_t bytes_done() const { return done_; }

 private:
  bool Spend();
  /// Leaves the byte between what it was and what it was to be.
  void Tear(std::size_t at, std::uint8_t goal);

  std::vector<std::uint8_t> bytes_;
  std::optional<std::uint64_t> left_{};
  Rng* rng_ = nullptr;
  std::uint64_t done_ = 0;
};

}  // namespace caltwin

#include "sim/firmware/flash.h"

#include <algorithm>

#include "sim/base/require.h"

namespace caltwin {
namespace {

constexpr std::size_t kPageBytes = 16;  // In hand at once.

}  // namespace

bool Flash::Spend() {
  if (left_ && *left_ == 0) return false;
  if (left_) --*left_;
  ++done_;
  return true;
}

void Flash::Tear(std::size_t at, std::uint8_t goal) {
  const auto mask = static_cast<std::uint8_t>(rng_->Next() & 0xFFU);
  bytes_[at] = static_cast<std::uint8_t>((bytes_[at] & mask) | (goal & ~mask));
}

bool Flash::Program(std::size_t at, std::span<const std::uint8_t> bytes) {
  Require(at + bytes.size() <= bytes_.size(), "the flash has that place");
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    if (Spend()) {
      bytes_[at + i] &= bytes[i];
      continue;
    }
    const std::size_t end = std::min(i + kPageBytes, bytes.size());
    for (std::size_t torn = i; torn < end && rng_ != nullptr; ++torn) {
      Tear(at + torn, bytes_[at + torn] & bytes[torn]);
    }
    rng_ = nullptr;
    return false;
  }
  return true;
}

bool Flash::Erase(std::size_t sector) {
  const std::size_t from = sector * kSectorBytes;
  Require(from + kSectorBytes <= bytes_.size(), "the flash has that sector");
  for (std::size_t at = from; at < from + kSectorBytes; ++at) {
    if (Spend()) {
      bytes_[at] = kErased;
      continue;
    }
    // A sector is erased as one: where the power goes, any part of it may be left.
    for (; at < from + kSectorBytes && rng_ != nullptr; ++at) Tear(at, kErased);
    rng_ = nullptr;
    return false;
  }
  return true;
}

}  // namespace caltwin

#include "sim/base/exact_sum.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "sim/base/require.h"

namespace caltwin {
namespace {

constexpr int kMantissaBits = 52;
constexpr int kLimbBits = 32;
constexpr int kLowest = -1074;  // Exponent of the last bit of the least double.
constexpr std::int32_t kBetweenCarries = 1 << 29;
constexpr std::uint64_t kLimbMask = (std::uint64_t{1} << kLimbBits) - 1;

}  // namespace

void ExactSum::Add(double value) {
  const auto bits = std::bit_cast<std::uint64_t>(value);
  const int biased = static_cast<int>(bits >> kMantissaBits & 0x7ff);
  Require(biased != 0x7ff, "a finite number is summed");
  std::uint64_t mantissa = bits & ((std::uint64_t{1} << kMantissaBits) - 1);
  if (biased != 0) mantissa |= std::uint64_t{1} << kMantissaBits;
  // Bits above kLowest of the mantissa's last one.
  const auto shift = static_cast<unsigned>(biased != 0 ? biased - 1 : 0);
  const std::size_t limb = shift / kLimbBits;
  const unsigned within = shift % kLimbBits;
  const std::uint64_t low = mantissa << within;
  const std::uint64_t high = within == 0 ? 0 : mantissa >> (64 - within);
  const std::int64_t sign = (bits >> 63) != 0 ? -1 : 1;
  limbs_[limb] += sign * static_cast<std::int64_t>(low & kLimbMask);
  limbs_[limb + 1] += sign * static_cast<std::int64_t>(low >> kLimbBits);
  limbs_[limb + 2] += sign * static_cast<std::int64_t>(high);
  if (--until_carry_ == 0) PassCarries();
}

void ExactSum::Add(const ExactSum& other) {
  ExactSum carried = other;
  carried.PassCarries();
  PassCarries();
  for (std::size_t i = 0; i < kLimbs; ++i) limbs_[i] += carried.limbs_[i];
  PassCarries();
}

void ExactSum::PassCarries() {
  for (std::size_t i = 0; i + 1 < kLimbs; ++i) {
    const std::int64_t carry = limbs_[i] >> kLimbBits;  // Rounds down.
    limbs_[i] -= carry << kLimbBits;
    limbs_[i + 1] += carry;
  }
  until_carry_ = kBetweenCarries;
}

std::array<std::int64_t, ExactSum::kLimbs> ExactSum::Limbs() const {
  ExactSum carried = *this;
  carried.PassCarries();
  return carried.limbs_;
}

std::optional<ExactSum> ExactSum::OfLimbs(std::span<const std::int64_t> limbs) {
  const auto is_limb = [](std::int64_t limb) {
    return limb >= 0 && limb <= static_cast<std::int64_t>(kLimbMask);
  };
  if (limbs.size() != kLimbs) return std::nullopt;
  if (!std::ranges::all_of(limbs.first(kLimbs - 1), is_limb)) return std::nullopt;
  ExactSum sum;
  std::ranges::copy(limbs, sum.limbs_.begin());
  return sum;
}

double ExactSum::Value() const {
  ExactSum carried = *this;
  carried.PassCarries();
  // Of a negative sum the top limb is: turn it round, so that limbs do not cancel.
  const bool is_negative = carried.limbs_[kLimbs - 1] < 0;
  if (is_negative) {
    for (std::int64_t& limb : carried.limbs_) limb = -limb;
    carried.PassCarries();
  }
  double value = 0;
  for (std::size_t i = 0; i < kLimbs; ++i) {
    value += std::ldexp(static_cast<double>(carried.limbs_[i]),
                        kLowest + kLimbBits * static_cast<int>(i));
  }
  return is_negative ? -value : value;
}

}  // namespace caltwin

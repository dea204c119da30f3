#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

namespace caltwin {

/// The sum of any number of doubles without rounding, so that it depends neither on
/// their order nor on how they were divided among threads or machines: a fixed-point
/// number of 2200 bits in limbs of 32, each with room for 2^29 additions until carries
/// are passed on (Neal 2015, "Fast exact summation using small and large
/// superaccumulators").
class ExactSum {
 public:
  /// Adds a finite number.
  void Add(double value);
  void Add(const ExactSum& other);
  /// The nearest double but for the last bit, the same for the same sum.
  double Value() const;

  static constexpr std::size_t kLimbs = 70;
  /// The whole sum, to be kept: limbs of 32 bits, the lowest first, the last with the
  /// sign. The same for the same sum.
  std::array<std::int64_t, kLimbs> Limbs() const;
  /// That sum again; nullopt where these are no limbs of one.
  static std::optional<ExactSum> OfLimbs(std::span<const std::int64_t> limbs);

 private:
  void PassCarries();

  std::array<std::int64_t, kLimbs> limbs_{};
  std::int32_t until_carry_ = 1 << 29;
};

}  // namespace caltwin

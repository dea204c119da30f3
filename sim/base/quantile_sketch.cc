#include "sim/base/quantile_sketch.h"

#include <bit>
#include <cmath>
#include <numeric>

namespace caltwin {
namespace {

constexpr int kPartBits = 7;  // 128 parts an octave.
constexpr int kLeastExponent = -40, kOctaves = 64;
constexpr std::int64_t kParts = std::int64_t{kOctaves} << kPartBits;  // Of one sign.

// Its least magnitude; part 0 is the smallest.
double MagnitudeOf(std::int64_t part) {
  const std::int64_t octave = part >> kPartBits;
  const std::int64_t within = part & ((1 << kPartBits) - 1);
  return std::ldexp(1 + static_cast<double>(within) / (1 << kPartBits),
                    kLeastExponent + static_cast<int>(octave));
}

}  // namespace

// Negative parts, the greatest magnitude first, then 0, then positive ones.
QuantileSketch::QuantileSketch() : counts_(2 * kParts + 1) {}

std::size_t QuantileSketch::IndexOf(double value) {
  const auto bits = std::bit_cast<std::uint64_t>(std::abs(value));
  // The exponent and the first bits of the mantissa count parts by themselves.
  const auto part = static_cast<std::int64_t>(bits >> (52 - kPartBits)) -
                    (std::int64_t{1023 + kLeastExponent} << kPartBits);
  if (part < 0) return kParts;
  const std::int64_t within = part < kParts ? part : kParts - 1;
  return static_cast<std::size_t>(value < 0 ? kParts - 1 - within
                                            : kParts + 1 + within);
}

void QuantileSketch::Add(const QuantileSketch& other) {
  for (std::size_t i = 0; i < counts_.size(); ++i) counts_[i] += other.counts_[i];
}

std::int64_t QuantileSketch::count() const {
  return std::accumulate(counts_.begin(), counts_.end(), std::int64_t{0});
}

std::vector<QuantileSketch::Part> QuantileSketch::Parts() const {
  std::vector<Part> parts;
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    if (counts_[i] == 0) continue;
    Part part{.count = counts_[i]};
    const auto index = static_cast<std::int64_t>(i);
    if (index < kParts) {
      part.low = -MagnitudeOf(kParts - index);
      part.high = -MagnitudeOf(kParts - 1 - index);
    } else if (index > kParts) {
      part.low = MagnitudeOf(index - kParts - 1);
      part.high = MagnitudeOf(index - kParts);
    }
    parts.push_back(part);
  }
  return parts;
}

QuantileSketch::Counted QuantileSketch::Counts() const {
  Counted counted;
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    if (counts_[i] != 0) counted.emplace_back(i, counts_[i]);
  }
  return counted;
}

std::optional<QuantileSketch> QuantileSketch::OfCounts(const Counted& counts) {
  QuantileSketch sketch;
  for (const auto& [part, count] : counts) {
    if (part < 0 || part > 2 * kParts || count < 1) return std::nullopt;
    sketch.counts_[static_cast<std::size_t>(part)] += count;
  }
  return sketch;
}

double QuantileSketch::Quantile(double p) const {
  const double wanted = p * static_cast<double>(count());
  double below = 0;
  double quantile = 0;
  for (const Part& part : Parts()) {
    const auto here = static_cast<double>(part.count);
    quantile = part.high;
    if (below + here >= wanted) {
      return std::lerp(part.low, part.high, (wanted - below) / here);
    }
    below += here;
  }
  return quantile;
}

}  // namespace caltwin

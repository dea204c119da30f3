#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace caltwin {

/// Quantiles of any number of values in a fixed 130 kB: how many fell into each of 64
/// octaves by 128 equal parts, of either sign. A quantile is right to 1/256 of itself;
/// magnitudes below 1e-12 count as 0, above 1.6e7 as that. Counts add up, so the result
/// depends neither on order nor on who counted.
class QuantileSketch {
 public:
  QuantileSketch();

  void Add(double value) { ++counts_[IndexOf(value)]; }
  void Add(const QuantileSketch& other);

  std::int64_t count() const;
  /// p in 0 .. 1; 0 where nothing was counted.
  double Quantile(double p) const;
  /// Least and greatest value, and how many, of each part that holds any, ascending.
  struct Part {
    double low = 0, high = 0;
    std::int64_t count = 0;
  };
  std::vector<Part> Parts() const;

  /// What was counted, to be kept: the number of a part, ascending, and how many.
  using Counted = std::vector<std::pair<std::int64_t, std::int64_t>>;
  Counted Counts() const;
  /// That again; nullopt where a number is no part's or a count less than 1.
  static std::optional<QuantileSketch> OfCounts(const Counted& counts);

 private:
  static std::size_t IndexOf(double value);

  std::vector<std::int64_t> counts_;  ///< From the most negative to the most positive.
};

}  // namespace caltwin

#include "calibration/estimate/correlation.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/require.h"

namespace caltwin {

Correlations CorrelationsOf(std::string procedure,
                            std::vector<std::string> names,
                            const Eigen::MatrixXd& covariance) {
  const Eigen::Index size = std::ssize(names);
  Require(covariance.rows() == size && covariance.cols() == size,
          "a covariance has a row and a column a name");
  Correlations of{.procedure = std::move(procedure),
                  .names = std::move(names),
                  .matrix = Eigen::MatrixXd::Identity(size, size)};
  for (Eigen::Index i = 0; i < size; ++i) {
    for (Eigen::Index j = 0; j < size; ++j) {
      const double both = std::sqrt(covariance(i, i) * covariance(j, j));
      if (i == j || !(both > 0)) continue;
      of.matrix(i, j) = std::clamp(covariance(i, j) / both, -1.0, 1.0);
    }
  }
  return of;
}

std::vector<CorrelatedPair> LargestPairs(const Correlations& of,
                                         std::size_t most,
                                         double least) {
  std::vector<CorrelatedPair> pairs;
  for (std::size_t i = 0; i < of.names.size(); ++i) {
    for (std::size_t j = i + 1; j < of.names.size(); ++j) {
      const double r =
          of.matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
      if (std::abs(r) >= least) pairs.push_back({of.names[i], of.names[j], r});
    }
  }
  std::ranges::stable_sort(
      pairs, std::ranges::greater{}, [](const auto& pair) { return std::abs(pair.r); });
  if (pairs.size() > most) pairs.resize(most);
  return pairs;
}

std::string MostCorrelatedText(const Correlations& of) {
  constexpr std::size_t kShown = 3;
  constexpr double kWorthSaying = 0.1, kLarge = 0.3;
  std::vector<std::string> words;
  const std::size_t all = of.names.size() * of.names.size();
  const std::size_t large = LargestPairs(of, all, kLarge).size();
  for (const CorrelatedPair& pair : LargestPairs(of, kShown, kWorthSaying)) {
    words.push_back(fmt::format("{} with {} {:+.2f}", pair.first, pair.second, pair.r));
  }
  if (large > kShown) {
    words.push_back(fmt::format("{} more of {:.1f} and more", large - kShown, kLarge));
  }
  return fmt::format("{}", fmt::join(words, ", "));
}

}  // namespace caltwin

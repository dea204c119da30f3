#include "scenarios/study/error_moments.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace caltwin {

void ErrorMoments::Add(const TrialResult& result) {
  std::vector<std::pair<std::size_t, double>> told;
  for (const ParameterResult& parameter : result.parameters) {
    if (!parameter.error) continue;
    const auto [it, is_new] = places_.try_emplace(parameter.name, first_.size());
    if (is_new) {
      first_.push_back(*parameter.error);
      pairs_.emplace_back(first_.size());
    }
    told.emplace_back(it->second, *parameter.error - first_[it->second]);
  }
  std::ranges::sort(told);
  for (std::size_t i = 0; i < told.size(); ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      const auto [place_a, a] = told[i];
      const auto [place_b, b] = told[j];
      Pair& pair = pairs_[place_a][place_b];
      ++pair.trials;
      pair.a += a;
      pair.b += b;
      pair.aa += a * a;
      pair.bb += b * b;
      pair.ab += a * b;
    }
  }
}

const ErrorMoments::Pair& ErrorMoments::Between(std::size_t i, std::size_t j) const {
  return pairs_[std::max(i, j)][std::min(i, j)];
}

std::int64_t ErrorMoments::least_trials() const {
  std::int64_t least = std::numeric_limits<std::int64_t>::max();
  for (const auto& row : pairs_) {
    for (const Pair& pair : row) least = std::min(least, pair.trials);
  }
  return pairs_.empty() ? 0 : least;
}

Correlations ErrorMoments::Result() const {
  constexpr std::int64_t kLeast = 3;
  if (first_.size() < 2 || least_trials() < kLeast) return {.procedure = kOfErrors};
  std::vector<std::string> names(first_.size());
  for (const auto& [name, place] : places_) names[place] = name;
  const auto size = static_cast<Eigen::Index>(first_.size());
  // Each pair by the trials that tell both: r, as a covariance of unit variances.
  Eigen::MatrixXd r = Eigen::MatrixXd::Identity(size, size);
  for (std::size_t i = 0; i < first_.size(); ++i) {
    for (std::size_t j = 0; j < first_.size(); ++j) {
      if (i == j) continue;
      const Pair& pair = Between(i, j);
      const auto n = static_cast<double>(pair.trials);
      const double both = std::sqrt(std::max(0.0, pair.aa - pair.a * pair.a / n) *
                                    std::max(0.0, pair.bb - pair.b * pair.b / n));
      if (!(both > 0)) continue;
      r(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          (pair.ab - pair.a * pair.b / n) / both;
    }
  }
  return CorrelationsOf(kOfErrors, std::move(names), r);
}

}  // namespace caltwin

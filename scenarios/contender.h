#pragma once

#include <algorithm>
#include <string>
#include <vector>

namespace caltwin {

/// Quantiles over machines, and the 95 % interval of the median (order statistics;
/// distribution-free).
struct Spread {
  double median = 0;
  double p95 = 0;
  double low = 0;
  double high = 0;
};
Spread SpreadOf(std::vector<double> values);

/// How one of several procedures did on many machines, by the figure that decides.
struct Contender {
  std::string name{};
  std::string about{};
  int machines = 0;  ///< Those with a figure.
  int failures = 0;  ///< Machines on which it told nothing or left things worse.
  Spread error_um{};
};

/// The standings of `comparison` by the figure that decides; `rivals` say what each is.
template <typename Comparison, typename Rivals, typename Standing>
std::vector<Contender> Contenders(const Comparison& comparison,
                                  const Rivals& rivals,
                                  Spread Standing::*figure) {
  std::vector<Contender> all;
  for (const Standing& standing : comparison.engines) {
    const auto rival = std::ranges::find_if(
        rivals, [&](const auto& one) { return one.name == standing.name; });
    all.push_back({.name = std::string(standing.name),
                   .about = rival == rivals.end() ? "" : std::string(rival->about),
                   .machines = comparison.machines,
                   .failures = standing.failures,
                   .error_um = standing.*figure});
  }
  return all;
}

}  // namespace caltwin

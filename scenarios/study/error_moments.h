#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "calibration/estimate/correlation.h"
#include "scenarios/study/study.h"

namespace caltwin {

/// How the errors of a contender's estimates go together over the machines of a study:
///
///   r_ij = cov(e_i, e_j) / (s_i s_j)   over the trials that tell both
///
/// which is what a procedure without a correlation of its own is asked for, and what
/// one with it may be held against.
class ErrorMoments {
 public:
  static constexpr const char* kOfErrors = "errors";  ///< In place of a procedure.

  void Add(const TrialResult& result);

  /// Names as they came first; without a name where fewer than three trials tell two
  /// estimates. What never errs goes with nothing.
  Correlations Result() const;
  /// Trials that tell the pair of which fewest do.
  std::int64_t least_trials() const;

 private:
  struct Pair {
    std::int64_t trials = 0;
    double a = 0, b = 0, aa = 0, bb = 0, ab = 0;  ///< Sums; errors less the first ones.
  };
  const Pair& Between(std::size_t i, std::size_t j) const;

  std::map<std::string, std::size_t> places_{};
  std::vector<double> first_{};             ///< Error of each, when it was told first.
  std::vector<std::vector<Pair>> pairs_{};  ///< [i][j], j <= i.
};

}  // namespace caltwin

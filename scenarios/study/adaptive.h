#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "scenarios/study/run.h"
#include "scenarios/study/store.h"

namespace caltwin {

/// The numerical tolerance of a result with so many significant digits, JCGM 101 7.9.2:
/// half of the last digit's unit, u = c 10^l with c a whole number of `digits` digits,
/// delta = 10^l / 2. 0 for u = 0.
double NumericalTolerance(double u, int digits);

/// What batches of trials say of one quantity: y, u(y) and the ends of its 95 %
/// interval, and how well each is known.
struct Settling {
  double y = 0, u = 0, low = 0, high = 0;  ///< Means over the batches.
  double delta = 0;                        ///< NumericalTolerance of u.
  /// Twice the standard deviation of the mean over the h batches of y, u, low and high,
  /// sqrt(sum (y_r - mean)^2 / (h (h - 1))), the greatest of the four.
  double twice_sd = 0;

  bool IsSettled() const { return twice_sd <= delta; }
};

/// Adaptive Monte Carlo, JCGM 101 7.9.4: batches of 10^4 trials until every quantity is
/// settled. Quantities are the errors of estimates.
class AdaptiveStop {
 public:
  explicit AdaptiveStop(int digits) : digits_(digits) {}

  /// The values of each quantity in one more batch, two or more.
  void AddBatch(const std::map<std::string, std::vector<double>>& values);
  /// By quantity; of those told in every batch.
  std::map<std::string, Settling> State() const;
  /// Whether there are two batches or more, something is told in every one and all of
  /// that is settled.
  bool IsSettled() const;

 private:
  /// y, u, low and high of one batch.
  using Batch = std::array<double, 4>;
  int digits_;
  std::size_t batches_ = 0;
  std::map<std::string, std::vector<Batch>> by_quantity_{};
};

inline constexpr std::int64_t kAdaptiveBatch = 10'000;  // JCGM 101: max(J, 10^4).

/// Runs batch after batch until the stop is settled, the study's limit is reached or
/// the person interrupts; what the store holds counts. `study->trials` becomes the
/// number that was needed. Where it stops depends on the study alone.
StudyProgress RunAdaptive(Study* study,
                          const StudyOptions& options,
                          StudyStore* store,
                          AdaptiveStop* stop);

/// What the terminal shows of it.
std::string SettlingText(const AdaptiveStop& stop);

}  // namespace caltwin

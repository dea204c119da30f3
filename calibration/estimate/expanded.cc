#include "calibration/estimate/expanded.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "calibration/estimate/clusters.h"
#include "sim/base/require.h"

namespace caltwin {
namespace {

constexpr double kNormal95 = 1.959963984540054;
constexpr double kAsGoodAsNormal = 1e3;  // Degrees of freedom: k 0.1 % larger.

// The argument at which a decreasing function falls to `level`.
template <typename Falling>
double FallsTo(double level, double high, Falling falling) {
  double low = 0;
  for (int halving = 0; halving < 100; ++halving) {
    const double middle = (low + high) / 2;
    (falling(middle) > level ? low : high) = middle;
  }
  return (low + high) / 2;
}

double NormalBelow(double z) {
  return std::erfc(-z / std::numbers::sqrt2) / 2;
}

double NormalFactor(double probability) {
  if (probability == 0.95) return kNormal95;
  return FallsTo(1 - probability, 40, [](double z) { return 2 * NormalBelow(-z); });
}

// Integral of the normal distribution up to z.
double NormalIntegral(double z) {
  const double density = std::exp(-z * z / 2) / std::sqrt(2 * std::numbers::pi);
  return z * NormalBelow(z) + density;
}

// P(|R + N| > limit): R rectangular in +-half, N normal with sd.
double Outside(double limit, double half, double sd) {
  if (sd < 1e-9 * half) return std::max(0.0, 1 - limit / half);
  const double inside =
      sd / half *
          (NormalIntegral((limit + half) / sd) - NormalIntegral((limit - half) / sd)) -
      1;
  return 1 - inside;
}

}  // namespace

double CoverageFactor(double dof, double probability) {
  Require(probability > 0 && probability < 1, "a probability between 0 and 1");
  if (!(dof < kAsGoodAsNormal)) return NormalFactor(probability);
  const int whole = std::max(1, static_cast<int>(std::floor(dof)));
  return FallsTo(
      1 - probability, 1e4, [whole](double t) { return StudentTwoSided(t, whole); });
}

double EffectiveDof(std::span<const Contribution> budget) {
  double variance = 0;
  double per_dof = 0;
  for (const Contribution& input : budget) {
    const double square = input.u * input.u;
    variance += square;
    per_dof += square * square / input.dof;
  }
  if (per_dof == 0) return std::numeric_limits<double>::infinity();
  return variance * variance / per_dof;
}

double CombinedU(std::span<const Contribution> budget) {
  double variance = 0;
  for (const Contribution& input : budget) variance += input.u * input.u;
  return std::sqrt(variance);
}

Expanded Expand(std::span<const Contribution> budget, double probability) {
  double variance = 0;
  double largest = 0;  // Variance of the largest rectangle.
  for (const Contribution& input : budget) {
    const double square = input.u * input.u;
    variance += square;
    if (input.is_rectangular) largest = std::max(largest, square);
  }
  Expanded expanded{.u = std::sqrt(variance), .dof = EffectiveDof(budget)};
  expanded.k = CoverageFactor(expanded.dof, probability);
  if (largest > 0) {
    const double half = std::sqrt(3 * largest);
    const double sd = std::sqrt(std::max(0.0, variance - largest));
    const double limit =
        FallsTo(1 - probability, 10 * expanded.u, [half, sd](double at) {
          return Outside(at, half, sd);
        });
    expanded.k *= limit / expanded.u / NormalFactor(probability);
  }
  expanded.U = expanded.k * expanded.u;
  return expanded;
}

Contribution InputOf(const std::string& input, double c, const Given& x) {
  const double widened = CoverageFactor(x.dof) / kNormal95;
  return {.input = input,
          .u = std::abs(c) * x.sd / widened,
          .dof = x.dof,
          .source = x.source,
          .sense = std::copysign(1.0, c) * x.sense};
}

Uncertain WithBudget(double value, std::vector<Contribution> budget) {
  for (const Contribution& input : budget) {
    if (!std::isfinite(input.u)) return {};
  }
  std::erase_if(budget, [](const Contribution& input) { return input.u == 0; });
  const double sd = Expand(budget).U / kNormal95;
  return {.value = value, .sd = sd, .identifiable = true, .budget = std::move(budget)};
}

void ScaleInput(double factor, Contribution* input) {
  input->u *= std::abs(factor);
  input->sense *= std::copysign(1.0, factor);
}

Uncertain Scaled(Uncertain estimate, double factor) {
  estimate.value *= factor;
  estimate.sd *= std::abs(factor);
  for (Contribution& input : estimate.budget) ScaleInput(factor, &input);
  return estimate;
}

Contribution NotCorrected(double offset, double sd) {
  const double size = std::abs(offset);
  Contribution added{.input = "kept, not corrected"};
  if (!(sd > 0) || size == 0) return added;
  const double limit = FallsTo(0.05, size + 10 * sd, [size, sd](double at) {
    return NormalBelow((size - at) / sd) + NormalBelow((-at - size) / sd);
  });
  const double together = limit / kNormal95;
  added.u = std::sqrt(std::max(0.0, together * together - sd * sd));
  return added;
}

std::vector<Contribution> ByInput(std::span<const Contribution> budget) {
  std::vector<Contribution> lines;
  for (const Contribution& input : budget) {
    const auto same = std::ranges::find(lines, input.input, &Contribution::input);
    if (same == lines.end()) {
      lines.push_back(input);
      continue;
    }
    const std::vector<Contribution> both{*same, input};
    *same = {.input = input.input,
             .u = CombinedU(both),
             .dof = EffectiveDof(both),
             .is_rectangular = same->is_rectangular && input.is_rectangular};
  }
  return lines;
}

Uncertain WithInput(Uncertain estimate,
                    const Contribution& input,
                    const std::string& own) {
  if (estimate.budget.empty()) {
    estimate.budget.push_back({.input = own, .u = estimate.sd});
  }
  if (input.u == 0) return estimate;
  estimate.budget.push_back(input);
  estimate.sd = Expand(estimate.budget).U / kNormal95;
  return estimate;
}

}  // namespace caltwin

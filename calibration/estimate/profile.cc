#include "calibration/estimate/profile.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "sim/base/require.h"

namespace caltwin {
namespace {

constexpr double kChi2Of95 = 3.841458820694124;
constexpr double kFarthest_sd = 20;
constexpr double kHeld_sd = 1e-5;  // Of its sd: how firmly a parameter is held.

// How far from the best, in standard deviations towards `sense`, the objective has
// risen by kChi2Of95: outwards until it has, then by halves and secants.
std::optional<double> SdsUntilRisen(const std::function<double(double)>& rise) {
  double inside = 0;
  double outside = 1.96;
  while (rise(outside) < kChi2Of95) {
    inside = outside;
    outside *= 1.5;
    if (outside > kFarthest_sd) return std::nullopt;
  }
  double at = outside;
  for (int step = 0; step < 25 && outside - inside > 1e-6; ++step) {
    const double at_inside = std::sqrt(std::max(0.0, rise(inside)));
    const double at_outside = std::sqrt(rise(outside));
    // The root of the rise is straight where the model is.
    const double part = (std::sqrt(kChi2Of95) - at_inside) / (at_outside - at_inside);
    at = inside + std::clamp(part, 0.02, 0.98) * (outside - inside);
    const double risen = rise(at);
    if (std::abs(risen - kChi2Of95) < 1e-5) break;
    (risen < kChi2Of95 ? inside : outside) = at;
  }
  return at;
}

}  // namespace

ProfileInterval ProfileOf(const std::function<double(double)>& objective,
                          double best,
                          double sd) {
  Require(sd > 0, "a standard deviation to begin with");
  const double least = objective(best);
  const auto towards = [&](double sense) {
    return SdsUntilRisen(
        [&](double by_sd) { return objective(best + sense * by_sd * sd) - least; });
  };
  const auto low = towards(-1);
  const auto high = towards(1.0);
  return {.low = best - low.value_or(kFarthest_sd) * sd,
          .high = best + high.value_or(kFarthest_sd) * sd,
          .is_closed = low && high};
}

ProfileInterval ProfileJoint(const JointProblem& problem,
                             const JointFit& fit,
                             std::size_t parameter) {
  Require(parameter < problem.free.size(), "a free parameter");
  const JointEstimate& estimate = fit.estimates[parameter];
  JointProblem held = problem;
  held.loss = Loss::kSquares;
  held.with_robust = false;
  const std::optional<Given> measured = problem.free[parameter].measured;
  return ProfileOf(
      [&](double value) {
        held.free[parameter].measured =
            Given{.value = value, .sd = kHeld_sd * estimate.sd};
        double objective = FitJoint(held).objective;
        if (measured && std::isfinite(measured->sd) && measured->sd > 0) {
          objective += std::pow((value - measured->value) / measured->sd, 2);
        }
        return objective;
      },
      estimate.value,
      estimate.sd);
}

}  // namespace caltwin

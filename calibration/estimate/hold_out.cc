#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "calibration/estimate/joint.h"
#include "sim/effects/predict.h"

namespace caltwin {
namespace {

// Reading less prediction; false where a nuisance of it was not estimated.
bool HeldOutResidual_mm(const JointProblem& problem,
                        const JointFit& fit,
                        std::span<const Injected> effects,
                        const Observation& observation,
                        double* residual_mm) {
  *residual_mm = observation.value_mm -
                 Predict_mm<double>(problem.machine, observation.at, effects);
  for (const auto& [name, coefficient] : observation.nuisances) {
    const JointEstimate* nuisance = fit.Find(name);
    if (nuisance == nullptr || !nuisance->identifiable) return false;
    *residual_mm -= coefficient * nuisance->value;
  }
  return true;
}

}  // namespace

std::vector<Injected> EstimatedEffects(const JointProblem& problem,
                                       const JointFit& fit) {
  std::vector<Injected> effects = problem.fixed;
  for (std::size_t i = 0; i < problem.free.size(); ++i) {
    const FreeParameter& parameter = problem.free[i];
    const auto same = [&](const Injected& effect) {
      return effect.effect == parameter.effect && effect.axis == parameter.axis;
    };
    auto found = std::ranges::find_if(effects, same);
    if (found == effects.end()) {
      effects.push_back(
          NeutralEffect(parameter.effect, parameter.axis, problem.machine));
      found = effects.end() - 1;
    }
    found->values[parameter.parameter] = fit.estimates[i].value;
  }
  return effects;
}

HoldOutError HoldOut(const JointProblem& problem) {
  std::set<std::string> groups;
  for (const Observation& observation : problem.observations) {
    groups.insert(observation.group);
  }
  HoldOutError error{.in_sample_rms_mm = FitJoint(problem).rms_mm};
  double squares_mm2 = 0;
  for (const std::string& group : groups) {
    JointProblem rest = problem;
    std::erase_if(rest.observations, [&](const Observation& observation) {
      return observation.group == group;
    });
    if (rest.observations.empty()) continue;
    const JointFit fit = FitJoint(rest);
    const std::vector<Injected> effects = EstimatedEffects(rest, fit);
    ++error.groups;
    for (const Observation& observation : problem.observations) {
      double residual_mm = 0;
      if (observation.group != group ||
          !HeldOutResidual_mm(rest, fit, effects, observation, &residual_mm)) {
        continue;
      }
      squares_mm2 += residual_mm * residual_mm;
      ++error.predicted;
    }
  }
  if (error.predicted > 0) {
    error.held_out_rms_mm = std::sqrt(squares_mm2 / error.predicted);
  }
  return error;
}

}  // namespace caltwin

#include "calibration/estimate/joint_model.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <ceres/jet.h>

#include "sim/base/require.h"
#include "sim/effects/catalog.h"
#include "sim/effects/injected.h"
#include "sim/effects/predict.h"

namespace caltwin {
namespace {

// Derivatives taken in one pass of the model: unknowns beyond it take further passes.
constexpr int kStride = 8;
using Jet = ceres::Jet<double, kStride>;

// Half of the 68 % interval, as a share of the middle.
double RelativeSd(const LogNormal& prior) {
  return (prior.factor - 1 / prior.factor) / 2;
}

struct AsNormal {
  double neutral;
  Given operator()(double value) const { return {.value = value, .sd = 0}; }
  Given operator()(const Normal& prior) const {
    return {.value = neutral + prior.mean, .sd = prior.sd};
  }
  Given operator()(const Uniform& prior) const {
    return {.value = (prior.min + prior.max) / 2,
            .sd = (prior.max - prior.min) / std::sqrt(12.0)};
  }
  Given operator()(const LogNormal& prior) const {
    const double middle = neutral != 0 ? neutral : prior.median;
    return {.value = middle, .sd = std::abs(middle) * RelativeSd(prior)};
  }
};

}  // namespace

Given DeclaredPrior(const Machine& machine, const FreeParameter& parameter) {
  const Injected neutral = NeutralEffect(parameter.effect, parameter.axis, machine);
  const Parameter& declared =
      EffectAt(parameter.effect).parameters[parameter.parameter];
  return std::visit(AsNormal{neutral.values[parameter.parameter]}, declared.prior);
}

JointModel::JointModel(const JointProblem& problem)
    : machine_(problem.machine),
      effects_(problem.fixed),
      observations_(problem.observations) {
  for (const FreeParameter& parameter : problem.free) AddParameter(problem, parameter);
  AddNuisances(problem);
}

void JointModel::AddParameter(const JointProblem& problem,
                              const FreeParameter& parameter) {
  const auto same = [&](const Injected& effect) {
    return effect.effect == parameter.effect && effect.axis == parameter.axis;
  };
  auto found = std::ranges::find_if(effects_, same);
  if (found == effects_.end()) {
    effects_.push_back(NeutralEffect(parameter.effect, parameter.axis, machine_));
    found = effects_.end() - 1;
  }
  slots_.push_back({.effect = static_cast<std::size_t>(found - effects_.begin()),
                    .parameter = parameter.parameter});

  const Given declared = DeclaredPrior(problem.machine, parameter);
  const Parameter& declaration =
      EffectAt(parameter.effect).parameters[parameter.parameter];
  Unknown unknown{
      .name = ParameterName(parameter.effect, parameter.axis, parameter.parameter),
      .unit = std::string(declaration.unit),
      .start = found->values[parameter.parameter],
      .scale = declared.sd > 0 ? declared.sd : 1,
      .prior = parameter.prior.value_or(declared),
      .measured = parameter.measured.value_or(kNotGiven),
      // A pre-travel or a screw cannot be negative or nothing; a gap may come out
      // slightly negative, and cutting that off would bias what is near zero.
      .min = declaration.min > 0 ? declaration.min
                                 : -std::numeric_limits<double>::infinity()};
  if (std::isfinite(unknown.prior.sd)) unknown.start = unknown.prior.value;
  if (std::isfinite(unknown.measured.sd)) unknown.start = unknown.measured.value;
  unknowns_.push_back(std::move(unknown));
}

void JointModel::AddNuisances(const JointProblem& problem) {
  std::map<std::string, Eigen::Index> index;
  for (const Observation& observation : observations_) {
    Require(observation.sigma_mm > 0, "an observation has a standard deviation");
    for (const auto& [name, coefficient] : observation.nuisances) index[name] = 0;
  }
  for (auto& [name, at] : index) {
    at = size();
    const auto known = problem.nuisances.find(name);
    const Given measured = known == problem.nuisances.end() ? kNotGiven : known->second;
    unknowns_.push_back({.name = name,
                         .unit = name.ends_with(".turn") ? "rad" : "mm",
                         .start = measured.value,
                         .prior = kNotGiven,
                         .measured = measured,
                         .min = -std::numeric_limits<double>::infinity(),
                         .is_nuisance = true});
  }
  for (const Observation& observation : observations_) {
    std::vector<Term> terms;
    for (const auto& [name, coefficient] : observation.nuisances) {
      terms.push_back({.unknown = index[name], .coefficient = coefficient});
    }
    terms_.push_back(std::move(terms));
  }
}

template <typename T>
std::vector<Valued<T>> JointModel::Effects() const {
  std::vector<Valued<T>> effects;
  for (const Injected& effect : effects_) {
    effects.push_back({.effect = effect.effect,
                       .axis = effect.axis,
                       .values = {effect.values.begin(), effect.values.end()}});
  }
  return effects;
}

double JointModel::Residual(std::size_t observation,
                            const double* u,
                            double* gradient) const {
  const Observation& reading = observations_[observation];
  const auto num_free = static_cast<int>(slots_.size());
  std::vector<Valued<Jet>> effects = Effects<Jet>();
  const auto at = [&](int i) -> Jet& {
    const Slot& slot = slots_[static_cast<std::size_t>(i)];
    return effects[slot.effect].values[slot.parameter];
  };
  for (int i = 0; i < num_free; ++i) {
    const Unknown& unknown = unknowns_[static_cast<std::size_t>(i)];
    at(i) = Jet(unknown.start + unknown.scale * u[i]);
  }

  double predicted_mm = 0;
  for (int first = 0; first == 0 || first < num_free; first += kStride) {
    const int last = std::min(first + kStride, num_free);
    for (int i = first; i < last; ++i) {
      at(i).v[i - first] = unknowns_[static_cast<std::size_t>(i)].scale;
    }
    const Jet predicted = Predict_mm<Jet>(machine_, reading.at, effects);
    predicted_mm = predicted.a;
    if (gradient == nullptr) break;
    for (int i = first; i < last; ++i) {
      gradient[i] = -predicted.v[i - first] / reading.sigma_mm;
      at(i).v[i - first] = 0;
    }
  }
  if (gradient != nullptr) std::fill(gradient + num_free, gradient + size(), 0.0);
  for (const auto& [index, coefficient] : terms_[observation]) {
    const Unknown& unknown = unknowns_[static_cast<std::size_t>(index)];
    predicted_mm += coefficient * (unknown.start + unknown.scale * u[index]);
    if (gradient != nullptr) {
      gradient[index] = -coefficient * unknown.scale / reading.sigma_mm;
    }
  }
  return (reading.value_mm - predicted_mm) / reading.sigma_mm;
}

Eigen::VectorXd JointModel::Residuals(const Eigen::VectorXd& u,
                                      Eigen::MatrixXd* gradient) const {
  const auto rows = static_cast<Eigen::Index>(num_observations());
  Eigen::VectorXd residuals(rows);
  Eigen::VectorXd row_gradient(size());
  if (gradient != nullptr) gradient->resize(rows, size());
  for (Eigen::Index row = 0; row < rows; ++row) {
    residuals[row] = Residual(static_cast<std::size_t>(row),
                              u.data(),
                              gradient != nullptr ? row_gradient.data() : nullptr);
    if (gradient != nullptr) gradient->row(row) = row_gradient.transpose();
  }
  return residuals;
}

Eigen::VectorXd JointModel::Values(const Eigen::VectorXd& u) const {
  Eigen::VectorXd values(size());
  for (Eigen::Index i = 0; i < size(); ++i) {
    const Unknown& unknown = unknowns_[static_cast<std::size_t>(i)];
    values[i] = unknown.start + unknown.scale * u[i];
  }
  return values;
}

}  // namespace caltwin

#include "scenarios/study/plan_study.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "sim/base/normals.h"
#include "sim/base/units.h"
#include "sim/effects/predict.h"
#include "sim/kinds/perform.h"
#include "sim/machine/machine_kind.h"
#include "sim/measure/in_force.h"

namespace caltwin {

namespace fs = std::filesystem;

namespace {

constexpr double kIdeal_mm = 1e-6;  // Stated of a reading whose instrument is ideal.

// The median of what is drawn and its root mean square about that: the population, as
// the estimate's prior.
struct AboutMedian {
  Given operator()(double value) const { return {.value = value, .sd = 0}; }
  Given operator()(const Normal& normal) const {
    return {.value = normal.mean, .sd = normal.sd};
  }
  Given operator()(const Uniform& uniform) const {
    return {.value = (uniform.min + uniform.max) / 2,
            .sd = (uniform.max - uniform.min) / std::sqrt(12.0)};
  }
  Given operator()(const LogNormal& log_normal) const {
    const double variance = std::pow(std::log(log_normal.factor), 2);
    // E (x / median - 1)^2 with ln x normal.
    const double square = std::exp(2 * variance) - 2 * std::exp(variance / 2) + 1;
    return {.value = log_normal.median, .sd = log_normal.median * std::sqrt(square)};
  }
};

// What a row's instrument and the motors' steps leave open.
double Sigma_mm(const Row& row, const DataHeader& header, const Machine& machine) {
  double variance_mm2 = 0;
  for (const Axis axis : kAxes) {
    const double n = row.n[static_cast<std::size_t>(Index(axis))];
    if (!Known(n)) continue;
    const double step_mm = 1 / machine.axis(axis).steps_per_mm();
    variance_mm2 += n * n * step_mm * step_mm / 12;
  }
  const auto campaign = header.campaigns.find(row.campaign);
  if (campaign == header.campaigns.end()) return std::sqrt(variance_mm2);
  const auto found = header.instruments.find(campaign->second.instrument);
  if (found == header.instruments.end()) return std::sqrt(variance_mm2);
  const double sigma_mm = MmFromUm(found->second.sigma_um);
  const double resolution_mm = MmFromUm(found->second.resolution_um);
  return std::sqrt(variance_mm2 + sigma_mm * sigma_mm +
                   resolution_mm * resolution_mm / 12);
}

void RefuseWithoutArtefact(const std::vector<InjectedSpec>& effects,
                           const DataHeader& header) {
  std::vector<std::string> ids;
  for (const auto& [id, artefact] : header.artefacts) ids.push_back(id);
  Faults faults;
  RefuseUnknownArtefacts(effects, ids, &faults);
  faults.ThrowIfAny();
}

}  // namespace

PlanStudy::PlanStudy(const fs::path& plan_file, Scenario varied, std::uint64_t seed)
    : varied_(std::move(varied)), seed_(seed) {
  const Machine& machine = varied_.machine.machine;
  if (!machine.kind->moves_along_axes()) {
    throw InputError(
        {.file = plan_file.string()},
        fmt::format("is a plan of a {}, which studies of plans do not know",
                    machine.kind->name()),
        "study a scenario of it");
  }
  session_ = PlanSession(ReadPlan(plan_file), machine, seed);
  session_.header.settings["1"] = AsHeader(machine.settings, *machine.kind);
  RefuseWithoutArtefact(varied_.effects, session_.header);
  for (Row& row : session_.rows) {
    row.settings = "1";
    row.sigma_mm = std::max(kIdeal_mm, Sigma_mm(row, session_.header, machine));
  }
  for (const InjectedSpec& spec : varied_.effects) {
    const auto parameters = EffectAt(spec.effect).parameters;
    for (std::size_t p = 0; p < std::min(spec.values.size(), parameters.size()); ++p) {
      if (std::holds_alternative<double>(spec.values[p])) continue;
      free_.push_back({.effect = spec.effect,
                       .axis = spec.axis,
                       .parameter = p,
                       .prior = std::visit(AboutMedian{}, spec.values[p])});
      drawn_.push_back(
          {.stream = fmt::format(
               "{}.{}.{}", EffectAt(spec.effect).name, spec.axis, parameters[p].name),
           .value = spec.values[p],
           .min = parameters[p].min,
           .max = parameters[p].max});
    }
  }
  if (free_.empty()) {
    throw InputError({.file = plan_file.string()},
                     "nothing is varied, so there is nothing to estimate",
                     "`vary` names parameters with distributions");
  }
  MakeDesign();
}

JointProblem PlanStudy::ProblemOf(const RowTable& table,
                                  const std::vector<Injected>& known) const {
  const Machine& machine = varied_.machine.machine;
  return {
      .machine = machine,
      .fixed = known,
      .free = free_,
      .observations = ObservationsOf(table, machine, {.default_sigma_mm = kIdeal_mm})};
}

void PlanStudy::MakeDesign() {
  std::vector<Injected> median;
  for (const InjectedSpec& spec : varied_.effects) {
    Injected effect{.effect = spec.effect, .axis = spec.axis};
    for (const Distribution& value : spec.values) {
      effect.values.push_back(std::visit(AboutMedian{}, value).value);
    }
    median.push_back(std::move(effect));
  }
  PerformConfig config{.machine = varied_.machine.machine,
                       .effects = median,
                       .header = session_.header,
                       .fidelity = Fidelity::kFast,
                       .seed = seed_,
                       .is_noisy = false};
  problem_ = ProblemOf(Perform(config, session_.rows), median);
  design_ = DesignOf(problem_);
  gain_.assign(design_.gain.data(), design_.gain.data() + design_.gain.size());
}

ObservabilityReport PlanStudy::Observe() const {
  return ObserveJoint(problem_);
}

RunResult PlanStudy::ResultOf(std::int64_t trial, const char* fidelity) const {
  RunResult result{.scenario = varied_.file.string(),
                   .about = varied_.about,
                   .machine = varied_.machine.machine.name,
                   .passed = true,
                   .outcome = "fitted",
                   .fidelity = fidelity,
                   .seed = seed_,
                   .machine_time_s = session_.duration_s,
                   .touches = static_cast<int>(session_.rows.size())};
  std::vector<double> about_middle(free_.size());
  DrawAboutMiddle(trial, about_middle.data());
  for (std::size_t i = 0; i < free_.size(); ++i) {
    const LinearDesign::Unknown& unknown = design_.unknowns[i];
    result.parameters.push_back({.name = unknown.name,
                                 .unit = unknown.unit,
                                 .injected = unknown.middle + about_middle[i]});
  }
  return result;
}

JointProblem PlanStudy::Measured(std::int64_t trial, bool is_noisy) const {
  Rng rng(seed_, static_cast<std::uint64_t>(trial), "plan.readings");
  const auto effects =
      DrawEffects(varied_.effects, seed_, static_cast<std::uint64_t>(trial));
  PerformConfig config{.machine = varied_.machine.machine,
                       .effects = effects,
                       .header = session_.header,
                       .fidelity = Fidelity::kFast,
                       .seed = rng.Next(),
                       .is_noisy = is_noisy};
  // Free ones among the effects begin at their priors, whatever they truly are.
  return ProblemOf(Perform(config, session_.rows), effects);
}

RunResult PlanStudy::Fast(std::int64_t trial) const {
  RunResult result = ResultOf(trial, "fast");
  const JointFit fit = FitJoint(Measured(trial, true));
  if (!fit.converged) {
    result.outcome = "not_fitted";
    result.messages.push_back(fit.message);
    return result;
  }
  for (std::size_t i = 0; i < free_.size(); ++i) {
    const JointEstimate& estimate = fit.estimates[i];
    ParameterResult& row = result.parameters[i];
    row.identifiable = estimate.identifiable;
    if (!estimate.identifiable) continue;
    row.recovered = estimate.value;
    row.sd = estimate.sd;
    row.error = estimate.value - row.injected;
  }
  return result;
}

void PlanStudy::DrawAboutMiddle(std::int64_t trial, double* about_middle) const {
  for (std::size_t i = 0; i < drawn_.size(); ++i) {
    const Drawn& drawn = drawn_[i];
    Rng rng(seed_, static_cast<std::uint64_t>(trial), drawn.stream);
    const double value = std::clamp(Draw(drawn.value, &rng), drawn.min, drawn.max);
    about_middle[i] = value - design_.unknowns[i].middle;
  }
}

Eigen::VectorXd PlanStudy::NoiseOf(std::int64_t trial) const {
  const auto read = Measured(trial, true).observations;
  const auto ideal = Measured(trial, false).observations;
  Eigen::VectorXd noise(design_.gain.cols());
  for (std::size_t i = 0; i < read.size(); ++i) {
    noise[static_cast<Eigen::Index>(i)] =
        (read[i].value_mm - ideal[i].value_mm) / read[i].sigma_mm;
  }
  return noise;
}

RunResult PlanStudy::Linear(std::int64_t trial) const {
  RunResult result = ResultOf(trial, "linear");
  std::vector<double> about_middle(free_.size()), errors(free_.size());
  LinearErrors(trial, about_middle.data(), errors.data());
  for (std::size_t i = 0; i < free_.size(); ++i) {
    ParameterResult& row = result.parameters[i];
    row.identifiable = design_.unknowns[i].identifiable;
    if (!row.identifiable) continue;
    row.recovered = row.injected + errors[i];
    row.sd = design_.unknowns[i].sd;
    row.error = errors[i];
  }
  return result;
}

}  // namespace caltwin

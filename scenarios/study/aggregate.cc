#include "scenarios/study/aggregate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace caltwin {
namespace {

constexpr std::size_t kWorst = 5;
constexpr double kTwoSided95 = 1.959963984540054;

}  // namespace

void StreamedQuantiles::Add(double value) {
  ++count_;
  sum_.Add(value);
  squares_.Add(value * value);
  sketch_.Add(value);
}

void StreamedQuantiles::Add(const StreamedQuantiles& other) {
  count_ += other.count_;
  sum_.Add(other.sum_);
  squares_.Add(other.squares_);
  sketch_.Add(other.sketch_);
}

double StreamedQuantiles::MeanSquare() const {
  return count_ > 0 ? squares_.Value() / static_cast<double>(count_) : 0;
}

Quantiles StreamedQuantiles::Summary() const {
  Quantiles quantiles{.count = count_};
  if (count_ == 0) return quantiles;
  const auto count = static_cast<double>(count_);
  quantiles.mean = sum_.Value() / count;
  const double about_mean = squares_.Value() - count * quantiles.mean * quantiles.mean;
  quantiles.sd = count_ > 1 ? std::sqrt(std::max(0.0, about_mean) / (count - 1)) : 0;
  quantiles.q025 = sketch_.Quantile(0.025);
  quantiles.median = sketch_.Quantile(0.5);
  quantiles.q975 = sketch_.Quantile(0.975);
  SetShortest([this](double p) { return sketch_.Quantile(p); }, &quantiles);
  return quantiles;
}

void StreamedParameter::Add(std::optional<double> error, std::optional<double> sd) {
  ++trials_;
  if (!error) return;
  errors_.Add(*error);
  if (!sd || !(*sd > 0)) return;
  ++with_sd_;
  held_ += std::abs(*error) <= kTwoSided95 * *sd ? 1 : 0;
  variances_.Add(*sd * *sd);
  squares_.Add(*error * *error);
}

void StreamedParameter::Add(const ParameterResult& result) {
  Add(result.error, result.sd);
  const auto combined = CombinedOf(result);
  if (!result.error || !combined) return;
  const double square = combined->u * combined->u;
  ++with_u_;
  u2_.Add(square);
  u4_.Add(square * square);
  u4_per_dof_.Add(square * square / combined->dof);
}

void StreamedParameter::Add(const StreamedParameter& other) {
  errors_.Add(other.errors_);
  trials_ += other.trials_;
  with_sd_ += other.with_sd_;
  held_ += other.held_;
  variances_.Add(other.variances_);
  squares_.Add(other.squares_);
  with_u_ += other.with_u_;
  u2_.Add(other.u2_);
  u4_.Add(other.u4_);
  u4_per_dof_.Add(other.u4_per_dof_);
}

ParameterSummary StreamedParameter::Summary(const std::string& name) const {
  ParameterSummary summary{.name = name,
                           .unit = unit,
                           .is_setting = is_setting,
                           .error = errors_.Summary(),
                           .coverage95 = RateOf(held_, with_sd_)};
  summary.identified = RateOf(summary.error.count, trials_);
  summary.histogram = EmptyHistogram(summary.error);
  for (const QuantileSketch::Part& part : errors_.sketch().Parts()) {
    CountIn((part.low + part.high) / 2, part.count, &summary.histogram);
  }
  if (with_sd_ > 0) {
    summary.mean_sd = std::sqrt(variances_.Value() / static_cast<double>(with_sd_));
    summary.rms_over_sd = std::sqrt(squares_.Value() / variances_.Value());
    StatedMean mean{.fourth_u = u4_.Value(), .fourth_u_per_dof = u4_per_dof_.Value()};
    if (with_u_ > 0) mean.square_u = u2_.Value() / static_cast<double>(with_u_);
    summary.stated = ExpandedOf(mean, summary.mean_sd);
    summary.gum = ValidationOf(summary.error, summary.mean_sd, /*digits=*/1);
  }
  return summary;
}

void Worst::Add(double value, std::int64_t trial) {
  if (worst_.size() == kWorst && -value > worst_.back().first) return;
  worst_.emplace_back(-value, trial);
  std::ranges::sort(worst_);
  if (worst_.size() > kWorst) worst_.pop_back();
}

void Worst::Add(const Worst& other) {
  for (const auto& [minus_value, trial] : other.worst_) Add(-minus_value, trial);
}

std::vector<std::int64_t> Worst::trials() const {
  std::vector<std::int64_t> trials;
  for (const auto& [minus_value, trial] : worst_) trials.push_back(trial);
  return trials;
}

Aggregate::Aggregate(
    std::int64_t fitted,
    const std::vector<std::pair<std::string, StreamedParameter>>& parameters,
    Worst worst)
    : is_of_plan_(true), status_{{"fitted", fitted}}, worst_(std::move(worst)) {
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const auto& [name, values] = parameters[i];
    parameters_.push_back({.name = name, .first = {0, i}, .values = values});
  }
}

void Aggregate::Add(const TrialResult& result) {
  ++status_[result.status];
  if (const std::string cause = CauseKey(result); !cause.empty()) ++causes_[cause];
  worst_.Add(Badness(result, is_of_plan_), result.trial);
  if (result.HasFailed()) return;
  machine_time_s_.Add(result.machine_time_s);
  touches_.Add(result.touches);
  before_mm_.Add(result.position_error_before_mm);
  after_mm_.Add(result.position_error_after_mm);
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    const ParameterResult& own = result.parameters[i];
    Parameter& parameter = Of(own.name);
    const std::pair first{result.trial, i};
    if (first < parameter.first) {
      parameter.first = first;
      parameter.values.unit = own.unit;
      parameter.values.is_setting = own.is_setting;
    }
    parameter.values.Add(own);
  }
}

// A handful, in the same order in every trial: a search from the front is quick.
Aggregate::Parameter& Aggregate::Of(const std::string& name) {
  const auto found = std::ranges::find(parameters_, name, &Parameter::name);
  if (found != parameters_.end()) return *found;
  constexpr auto kNotYet = std::numeric_limits<std::int64_t>::max();
  parameters_.push_back({.name = name, .first = {kNotYet, 0}});
  return parameters_.back();
}

void Aggregate::Add(const Aggregate& other) {
  for (const auto& [status, count] : other.status_) status_[status] += count;
  for (const auto& [cause, count] : other.causes_) causes_[cause] += count;
  machine_time_s_.Add(other.machine_time_s_);
  touches_.Add(other.touches_);
  before_mm_.Add(other.before_mm_);
  after_mm_.Add(other.after_mm_);
  for (const Parameter& own : other.parameters_) {
    Parameter& parameter = Of(own.name);
    if (own.first < parameter.first) {
      parameter.first = own.first;
      parameter.values.unit = own.values.unit;
      parameter.values.is_setting = own.values.is_setting;
    }
    parameter.values.Add(own.values);
  }
  worst_.Add(other.worst_);
}

std::int64_t Aggregate::trials() const {
  std::int64_t trials = 0;
  for (const auto& [status, count] : status_) trials += count;
  return trials;
}

CaseSummary Aggregate::Summary(const StudyCase& of) const {
  CaseSummary summary{.name = of.Name(),
                      .scenario = of.scenario.file.string(),
                      .procedure = of.procedure,
                      .status = status_,
                      .causes = causes_,
                      .machine_time_s = machine_time_s_.Summary(),
                      .touches = touches_.Summary(),
                      .position_error_before_mm = before_mm_.Summary(),
                      .position_error_after_mm = after_mm_.Summary(),
                      .worst = worst_.trials()};
  std::vector<Parameter> ordered = parameters_;
  std::ranges::sort(ordered, {}, &Parameter::first);
  for (const Parameter& parameter : ordered) {
    summary.parameters.push_back(parameter.values.Summary(parameter.name));
  }
  return summary;
}

}  // namespace caltwin

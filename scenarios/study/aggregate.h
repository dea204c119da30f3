#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "scenarios/study/summary.h"
#include "sim/base/exact_sum.h"
#include "sim/base/quantile_sketch.h"

namespace caltwin {

/// Mean, standard deviation and quantiles of any number of values in fixed memory. The
/// same whatever the order and whoever added them: sums are exact, quantiles right to
/// 1/256 of themselves.
class StreamedQuantiles {
 public:
  void Add(double value);
  void Add(const StreamedQuantiles& other);
  Quantiles Summary() const;
  const QuantileSketch& sketch() const { return sketch_; }
  double MeanSquare() const;

 private:
  std::int64_t count_ = 0;
  ExactSum sum_{}, squares_{};
  QuantileSketch sketch_{};
};

/// What a contender's estimates of one parameter come to, trial by trial.
class StreamedParameter {
 public:
  /// One trial: its error and stated standard deviation, where it told and stated any.
  void Add(std::optional<double> error, std::optional<double> sd);
  void Add(const StreamedParameter& other);
  ParameterSummary Summary(const std::string& name) const;

  std::string unit{};
  bool is_setting = false;

 private:
  StreamedQuantiles errors_{};
  std::int64_t trials_ = 0, with_sd_ = 0, held_ = 0;
  ExactSum variances_{}, squares_{};  ///< Where an sd was stated.
};

/// Trials with the greatest value, the greatest first; of equal ones the first trial.
class Worst {
 public:
  void Add(double value, std::int64_t trial);
  void Add(const Worst& other);
  std::vector<std::int64_t> trials() const;

 private:
  std::vector<std::pair<double, std::int64_t>> worst_{};  ///< Minus the value.
};

/// A summary that needs no trials kept: memory does not grow with them.
class Aggregate {
 public:
  explicit Aggregate(bool is_of_plan = false) : is_of_plan_(is_of_plan) {}
  void Add(const TrialResult& result);
  CaseSummary Summary(const StudyCase& of) const;

 private:
  bool is_of_plan_;
  std::map<std::string, std::int64_t> status_{}, causes_{};
  StreamedQuantiles machine_time_s_{}, touches_{}, before_mm_{}, after_mm_{};
  /// In the order in which the first trial has them.
  std::vector<std::pair<std::string, StreamedParameter>> parameters_{};
  Worst worst_{};
};

}  // namespace caltwin

#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "scenarios/study/summary.h"
#include "sim/base/exact_sum.h"
#include "sim/base/quantile_sketch.h"

namespace caltwin {

// Each of these can be written down and read again without loss, so that parts of a
// study may be put together: ToJson, and OfJson, which throws nlohmann::json::exception
// or std::invalid_argument where the tree is none of it.

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
  nlohmann::json ToJson() const;
  static StreamedQuantiles OfJson(const nlohmann::json& json);

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
  /// The same, and what its sd is made of.
  void Add(const ParameterResult& result);
  void Add(const StreamedParameter& other);
  ParameterSummary Summary(const std::string& name) const;
  nlohmann::json ToJson() const;
  static StreamedParameter OfJson(const nlohmann::json& json);

  std::string unit{};
  bool is_setting = false;

 private:
  StreamedQuantiles errors_{};
  std::int64_t trials_ = 0, with_sd_ = 0, held_ = 0;
  ExactSum variances_{}, squares_{};  ///< Where an sd was stated.
  std::int64_t with_u_ = 0;
  ExactSum u2_{}, u4_{}, u4_per_dof_{};  ///< StatedMean, where it was taken apart.
};

/// Trials with the greatest value, the greatest first; of equal ones the first trial.
class Worst {
 public:
  void Add(double value, std::int64_t trial);
  void Add(const Worst& other);
  std::vector<std::int64_t> trials() const;
  nlohmann::json ToJson() const;
  static Worst OfJson(const nlohmann::json& json);

 private:
  std::vector<std::pair<double, std::int64_t>> worst_{};  ///< Minus the value.
};

/// A summary that needs no trials kept: memory does not grow with them. The same
/// whatever the order of the trials and however they were divided among aggregates.
class Aggregate {
 public:
  explicit Aggregate(bool is_of_plan = false) : is_of_plan_(is_of_plan) {}
  /// Of so many trials of a linear design, its parameters in their order.
  Aggregate(std::int64_t fitted,
            const std::vector<std::pair<std::string, StreamedParameter>>& parameters,
            Worst worst);

  void Add(const TrialResult& result);
  /// Adds what another has seen of the same contender.
  void Add(const Aggregate& other);
  std::int64_t trials() const;
  CaseSummary Summary(const StudyCase& of) const;
  nlohmann::json ToJson() const;
  static Aggregate OfJson(const nlohmann::json& json);

 private:
  struct Parameter {
    std::string name{};
    /// The first trial that has it, and as the so-manyth: by these they are ordered.
    std::pair<std::int64_t, std::size_t> first{};
    StreamedParameter values{};
  };
  Parameter& Of(const std::string& name);

  bool is_of_plan_ = false;
  std::map<std::string, std::int64_t> status_{}, causes_{};
  StreamedQuantiles machine_time_s_{}, touches_{}, before_mm_{}, after_mm_{};
  std::vector<Parameter> parameters_{};
  Worst worst_{};
};

}  // namespace caltwin

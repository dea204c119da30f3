#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "sim/base/yaml.h"

namespace caltwin {

/// How a run may end, on every kind of machine; scenarios/judge.h says by which rule.
inline constexpr std::array kOutcomes = {"recovers",
                                         "diverges",
                                         "no_trigger",
                                         "collision",
                                         "reads_zero",
                                         "confounded",
                                         "refused",
                                         "alarm",
                                         "misses"};

/// A value that must lie within a distance of another.
struct Near {
  double value = 0;
  double within = 0;
};

/// What a scenario expects of one parameter; each key that is given is a check.
struct ParameterExpectation {
  std::string name{};
  std::optional<double> truth_within{};  ///< abs(recovered - built) at most this.
  std::optional<bool> identifiable{};
  std::optional<double> sd_below{};         ///< Stated uncertainty below this.
  std::optional<double> truth_within_sd{};  ///< abs(error) at most so many sd.
  std::optional<Near> reads{};              ///< What it ends at, right or wrong.
  /// The values after its steps, in order: at least so many steps, each near.
  std::vector<double> steps{};
  double steps_within = 0;
};

/// Bounds of a figure that a scenario expects.
struct Within {
  std::optional<double> above{};
  std::optional<double> below{};
};

/// What a scenario expects of one figure: `level_error_mm.mean: {below: 0.1}`.
struct FigureExpectation {
  std::string name{};
  Within within{};
};

/// What scenarios of one kind of machine may expect, beside an outcome and messages.
struct Expectable {
  std::vector<std::string> parameters{};
  std::vector<std::string> figures{};  ///< Those of every kind are not among them.
};

/// `expect:` of a scenario.
struct Expectation {
  std::string outcome = "recovers";
  std::vector<ParameterExpectation> parameters{};
  std::vector<FigureExpectation> figures{};
  std::vector<std::string> messages{};  ///< Each must occur in some message.
};

/// Reads `expect:` of any kind of machine. An entry that expects nothing is a fault, as
/// is a name that is not among `expectable`.
Expectation ReadExpectation(YamlMap map, const Expectable& expectable);

}  // namespace caltwin

#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "calibration/estimate/linear_fit.h"
#include "calibration/loop/outcome.h"

namespace caltwin {

/// One unknown: a column of the Jacobian.
struct UnknownColumn {
  std::string name{};      ///< "backlash.x", "placement.block.z".
  double mm_per_unit = 1;  ///< How many mm of a reading one unit is worth.
};

/// What a set of measurements tells of the unknowns, by algebra and noise alone.
struct ObservabilityReport {
  /// Noise-scaled rank: directions in the space of all unknowns (placements included)
  /// that the readings tell better than the rule asks.
  int rank = 0;
  int num_unknowns = 0;
  std::vector<std::string> determined{};    ///< Each told by itself.
  std::vector<std::string> undetermined{};  ///< Told in a combination, or not at all.
  /// One entry per blind direction; entries of one group share the statement.
  std::vector<Observability> blind{};
  /// Of the determined directions the one known least, as a unit vector in mm, in
  /// words, and its standard deviation.
  std::map<std::string, double> weakest{};
  std::string weakest_statement{};
  double weakest_sd_mm = 0;
  std::vector<std::string> advice{};  ///< What measurement would tell.
};

/// A direction known worse than this [mm] counts as blind.
inline constexpr RankRule kObservableRule{.relative = 1e-9, .largest_sd = 1.0};

/// The verdict of a whitened Jacobian (each row divided by its sigma; columns per unit
/// of the unknown, in the order of `columns`).
///
/// Statements read "probe_pretravel.x + backlash.x / 2 - tip_size only": that sum is
/// determined, none of its terms is; or "steps_per_mm.x not at all". Coefficients are
/// per mm (see mm_per_unit). Pre-travel leads a sum, then backlash, then the others;
/// placements come last.
ObservabilityReport Observe(const Eigen::MatrixXd& whitened_jacobian,
                            std::span<const UnknownColumn> columns,
                            const RankRule& rule = kObservableRule);

/// A linear combination in words, "a + b / 2 - 2/3 c": coefficients as fractions of
/// denominators up to 12 where they are one to a part in a thousand, else with three
/// digits; positive terms first, zero terms left out.
std::string CombinationInWords(std::span<const std::string> names,
                               const Eigen::VectorXd& coefficients);

/// What would tell the unknowns of one blind group apart; empty where nothing is known
/// to help. `names` are full names; the cause before the dot decides.
std::vector<std::string> AdviceFor(std::span<const std::string> names);

}  // namespace caltwin

#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/machine/axis.h"
#include "sim/measure/row.h"

namespace caltwin {

/// The symbols of ISO 230-2:2014 for one axis [mm]; none where the readings do not tell
/// it (a direction that was not measured, a single run).
///
/// For positions i = 1 .. m, runs j = 1 .. n a direction, x_ij = actual - target, with
/// means and standard deviations of each direction (^ forward, v backward):
///
///     B_i = mean_i^ - mean_iv            mean_i = (mean_i^ + mean_iv) / 2
///     R_i^ = 4 s_i^                      R_i = max(2 s_i^ + 2 s_iv + |B_i|, R_i^,
///     R_iv) A = max(mean_i^ + 2 s_i^, mean_iv + 2 s_iv) - min(mean_i^ - 2 s_i^,
///         mean_iv - 2 s_iv),  over i and both directions at once
struct Iso230Symbols {
  std::optional<double> a{};       ///< A: accuracy, bidirectional.
  std::optional<double> r{};       ///< R: repeatability, bidirectional: max R_i.
  std::optional<double> e{};       ///< E: systematic error, bidirectional.
  std::optional<double> m{};       ///< M: range of the mean bidirectional error.
  std::optional<double> b{};       ///< B: largest |B_i|.
  std::optional<double> b_mean{};  ///< Mean of B_i, with its sign.
  std::optional<double> a_fwd{}, a_bwd{};
  std::optional<double> r_fwd{}, r_bwd{};
  std::optional<double> e_fwd{}, e_bwd{};
};

/// A symbol by the name it has in files and on the sheet ("A", "B_mean", "E_fwd").
struct NamedSymbol {
  std::string_view name;
  std::optional<double> Iso230Symbols::*value;
  std::string_view words;
};
std::span<const NamedSymbol> AllIso230Symbols();

/// One target position, both directions.
struct Iso230Position {
  double target_mm = 0;
  int runs_fwd = 0, runs_bwd = 0;
  std::optional<double> mean_fwd_mm{}, mean_bwd_mm{};
  std::optional<double> s_fwd_mm{}, s_bwd_mm{};  ///< None with fewer than two runs.
  std::optional<double> b_mm{};                  ///< Reversal value.
};

/// Standard uncertainties of the measurement itself [um], after ISO/TR 230-9; what is
/// not known is 0 and the sheet says so.
struct Iso230Budget {
  bool is_known = false;        ///< false: nothing is known and no U is stated.
  double device_u_um = 0;       ///< Scale of the device over the measured travel.
  double alignment_u_um = 0;    ///< Beam not parallel to the axis, over the travel.
  double temperature_u_um = 0;  ///< Expansion not corrected for, over the travel.
  double environment_u_um = 0;  ///< Drift during the measurement, a reading.
  double reading_u_um = 0;      ///< Scatter and resolution of the device, a reading.
};

/// Smallest and largest of what was recorded beside the readings; none: not recorded.
struct Span {
  double min = 0, max = 0;
};

/// The whole sheet of one axis in one campaign.
struct Iso230Sheet {
  Axis axis = Axis::kX;
  std::string campaign{};
  Iso230Symbols symbols{};                  ///< [mm]
  Iso230Symbols expanded_u{};               ///< U, k = 2 [mm]; none without a budget.
  std::vector<Iso230Position> positions{};  ///< Ascending.
  int runs_min = 0, runs_max = 0;           ///< Readings a position and direction.
  int rows_without_direction = 0;           ///< Left out: their sense is unknown.
  std::optional<Span> ambient_c{}, screw_c{}, time_s{}, feed_mm_s{};
  /// What a reader must know: directions missing, fewer runs or positions than the
  /// standard asks for, regular spacing, several placements.
  std::vector<std::string> remarks{};
};

/// An axis and a campaign for which rows hold a positioning measurement.
struct Iso230Choice {
  Axis axis = Axis::kX;
  std::string campaign{};
};

/// Whether a row is a gauge's reading along `axis`: of kind `position`, n within a
/// cosine error of 0.1 % of it, its commanded place known.
bool MeasuresAlong(const Row& row, Axis axis);

/// Every (campaign, axis) with `position` rows measured along that axis at two or more
/// targets of it, in file order. A straightness measurement (read across the motion) is
/// none.
std::vector<Iso230Choice> Iso230Choices(const RowTable& table);

/// Evaluates one choice. Pure.
///
/// x_ij is `value_mm`, turned to the axis where n points to its negative end. Readings
/// belong to one position where their targets differ by less than 0.1 um. Rows whose
/// direction is unknown or 0 are left out and counted; nothing else is left out, an
/// outlier neither. Bidirectional symbols need both directions at every position.
///
/// U to first order, from independent readings (u_r: reading and environment together)
/// and an error u_L common to the travel (device, alignment, temperature together):
///
///     u^2(B) = 2 u_r^2 / n       u^2(B_mean) = 2 u_r^2 / (n m)
///     u^2(R^) = 16 u_r^2 / (n - 1)
///     u^2(R) = u^2(R^), or 8 u_r^2 / (n - 1) + 2 u_r^2 / n where that branch is
///     largest u^2(E) = u^2(E^) = u_L^2 + 2 u_r^2 / n      u^2(M) = u_L^2 + u_r^2 / n
///     u^2(A) = u^2(A^) = u_L^2 + 2 u_r^2 (1 / n + 4 / (n - 1))
///
/// What the axis itself scatters is in the symbols, not in U. u_L is counted whole,
/// wherever on the travel the extremes lie; the selection of the extreme among the
/// positions is neglected.
Iso230Sheet EvaluateIso230(const RowTable& table,
                           const Iso230Choice& choice,
                           const Iso230Budget& budget = {});

}  // namespace caltwin

#pragma once

#include <optional>

#include "calibration/facts/levels.h"

namespace caltwin {

/// Kendall's S: pairs of readings that rise less those that fall.
double TrendSum(const Rows& rows);
/// Its variance where nothing drifts: n (n - 1) (2 n + 5) / 18.
double TrendVariance(const Rows& rows);

/// A series that drifts.
struct Drift {
  double change_mm = 0;  ///< Last less first, each smoothed over a tenth.
  double sd_mm = 0;      ///< Of the change.
  double noise_mm = 0;   ///< Of one reading about the drift.
};

/// What a series does from its first readings to its last, drift or not.
Drift ChangeOf(const Rows& rows, double resolution_mm);
/// The same where it is no chance; else none.
std::optional<Drift> DriftOf(const Rows& rows, double resolution_mm);

/// Rows before and after the one step that a series takes between two levels; empty
/// where a straight line explains it about as well, or either side drifts itself.
std::vector<std::vector<const Row*>> AtOneStep(const Rows& rows, double resolution_mm);

/// Whether any temperature differs by more than five kelvin among rows.
bool IsWarmed(const Rows& rows);

/// The fact "drift" of rows of one place.
void AddDrift(const Rows& rows, const Drift& drift, Facts* facts);

}  // namespace caltwin

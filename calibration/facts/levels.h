#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "calibration/facts/cells.h"
#include "calibration/facts/fact.h"

namespace caltwin {

double MeanOf(const Rows& rows);
double SquaresAbout(const Rows& rows, double mean_mm);
/// From each reading to the next [mm].
std::vector<double> StepsOf(const Rows& rows);
/// "X 10 Y 20", or "one place" where it is not known.
std::string PlaceInWords(const Row& row);

/// The size from which a step between readings is a jump, where two kinds of steps are
/// plain to see: at least two in five are eight times smaller than all the others.
std::optional<double> JumpSize_mm(const Rows& rows, double resolution_mm);

/// Two groups of values with a wide gap between them, taken in turn; empty where there
/// are none.
std::vector<Rows> TwoGroups(const Rows& rows, double resolution_mm);

/// Rows between the jumps. At least one row.
std::vector<Rows> SplitAtJumps(const Rows& rows, double jump_mm);

/// What is left, level by level, without readings that leave their level and come back
/// to it, or stand alone at an end: those are added to `outliers`.
std::vector<Rows> WithoutExcursions(std::vector<Rows> levels,
                                    double jump_mm,
                                    std::set<std::int64_t>* outliers);

/// Rows of each homing session, in the order of their first rows.
std::vector<Rows> ByHome(const Rows& rows);

/// Scatter about the mean of each batch.
struct BatchScatter {
  double squares_mm2 = 0;
  double dof = 0;
  double sd_mm() const;  ///< kUnknown without degrees of freedom.
};

BatchScatter ScatterWithin(const std::vector<Rows>& batches);

/// Batches of one place: how far their means scatter beyond what each shows by itself.
void AddHomings(const std::vector<Rows>& batches,
                bool are_homings,
                double resolution_mm,
                Facts* facts);

/// Two levels, the second of which stays.
void AddJump(const std::vector<Rows>& levels, Facts* facts);

}  // namespace caltwin

#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "sim/measure/row.h"

namespace caltwin {

using Rows = std::vector<const Row*>;

/// Axes as facts name them, by index.
inline constexpr std::array<const char*, 3> kAxisNames = {"x", "y", "z"};

/// What may differ between rows that are called repeats of each other.
enum CellFreedom : unsigned {
  kAnySense = 1,     ///< dir_x dir_y dir_z.
  kAnyFeed = 2,      ///< feed_mm_s.
  kAnyHome = 4,      ///< Homing session.
  kAnyCampaign = 8,  ///< Campaign and setup.
};

/// Rows that measured the same thing: place (to 1 um), normal, feature, probe and
/// artefact held alike, under the same settings.
using Cells = std::map<std::string, Rows>;

/// By key; rows in the order measured.
Cells CellsOf(const Rows& rows, unsigned freedom);

/// In the order measured.
Rows RowsInOrder(const RowTable& table);

/// Index of the axis along which a row is measured; -1 where it is none of them.
int AxisAlong(const Row& row);

}  // namespace caltwin

#pragma once

#include <vector>

#include "calibration/diagnosis/plausible.h"
#include "calibration/diagnosis/row_series.h"

namespace caltwin {

/// @name The parts of Doubts(), each adding to `doubts` what it finds.
/// @{

/// Rows one by one and in their order: finite, enough, not twice, times, temperatures,
/// steps, senses.
void DoubtRows(const RowTable& table, std::vector<Doubt>* doubts);

/// The rows without the campaigns of a triple-Z printer that move screws against each
/// other: swapped motors and wrong pivots make readings there that follow no command.
RowTable WithoutLoneScrews(const RowTable& table);

/// Sizes against each other and against what a machine can do: units, signs, positions
/// in place of deviations, stated sigmas.
/// `moved_alike`: those of `table` whose readings follow what is commanded. `machine`
/// may be null.
void DoubtSizes(const RowTable& table,
                const RowTable& moved_alike,
                const DataHeader& header,
                const Machine* machine,
                const KnownOfRows& known,
                std::vector<Doubt>* doubts);

/// Campaigns that measured the same places held alike, against each other: the
/// opposite, or in another unit.
void DoubtCampaigns(const RowTable& table, std::vector<Doubt>* doubts);

/// Runs of one campaign against the run that most others follow: the opposite, or in
/// another unit.
void DoubtRuns(const RowTable& table, std::vector<Doubt>* doubts);

/// Positions of a campaign in inches, centimetres or metres among others in mm: gauged
/// along the same axis, they read alike only where positions are multiplied.
void DoubtPositionUnits(const RowTable& table, std::vector<Doubt>* doubts);

/// Commands against the travel since the last reversal, in the order measured.
void DoubtMoves(const std::vector<const Row*>& rows, std::vector<Doubt>* doubts);

/// The gap of an axis in one campaign against another's.
void DoubtGaps(const std::vector<RowSeries>& all, std::vector<Doubt>* doubts);

/// Rows of a campaign in micrometres among others in mm.
void DoubtBlocks(const std::vector<const Row*>& rows, std::vector<Doubt>* doubts);

/// The mean over opposite faces in one campaign against another's.
void DoubtFaces(const std::vector<RowSeries>& all, std::vector<Doubt>* doubts);

/// Campaigns whose touches all come out of the material that they touch.
void DoubtApproach(const RowTable& table, std::vector<Doubt>* doubts);

/// Beyond its travel, as a part of it, an axis may stand: files are not that exact.
inline constexpr double kBeyondTravel = 0.05;

/// Whether an axis may stand at a position: within its travel and kBeyondTravel of it;
/// on towers, where rods reach, the other two at 0. Null: within 4 m of 0.
bool CanStandAt(const Machine* machine, int axis, double position_mm);

/// Positions against the travel of the axes.
void DoubtTravel(const RowTable& table,
                 const Machine& machine,
                 std::vector<Doubt>* doubts);

/// Gauged positions that in inches would be most of an axis' travel, and are a small
/// part of it as they stand.
void DoubtReachInInches(const RowTable& table,
                        const Machine& machine,
                        std::vector<Doubt>* doubts);

/// Steps/mm that were in force against those that the machine file's drives take.
void DoubtDrives(const DataHeader& header,
                 const Machine& machine,
                 std::vector<Doubt>* doubts);

/// @}

}  // namespace caltwin

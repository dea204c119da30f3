#pragma once

#include "calibration/diagnosis/observed.h"

namespace caltwin {

/// What counting in whole steps leaves open of a reading on a delta whose header states
/// the steps/mm in force; 0 where it does not [mm].
///
///   sqrt(sum over towers (n . dp/dmotor step)^2 / 12)
///
/// Repeats count the same steps, so they do not show it.
double RoundingSigma_mm(const Observed& observed, Eigen::Index i);

/// How far beyond its command a drive stands that moves in whole motor steps, of a
/// machine whose axes are moved by drives in proportion, round(q s) / s - q, s the
/// steps/mm that the header states for the row [mm]. 0 of touches, which end anywhere,
/// and where no steps are stated. Repeats share it.
double RoundedBy_mm(const Observed& observed, Eigen::Index i, int drive);

/// What counting a touch in whole motor steps of Z leaves open, of a campaign on a
/// printer that levels by its screws or at a station; 0 of others [mm].
///
///   (step / sqrt(12)) sqrt(1 + (n - 1) exp(-(2 pi s)^2))
///
/// Readings of one place that count the same step have its rounding in common: of n of
/// them as much is in their mean. Noise of s steps, as repeats show it, carries them
/// over steps and parts them.
double CountedSigma_mm(const Observed& observed, const std::string& campaign);

}  // namespace caltwin

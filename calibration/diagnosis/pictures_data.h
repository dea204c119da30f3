#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "calibration/diagnosis/diagnosis.h"
#include "calibration/diagnosis/observed.h"
#include "calibration/diagnosis/periodogram.h"

namespace caltwin {

/// The best of all candidates that show in a channel and depend on a covariate.
struct EvidenceCell {
  std::string channel{};    ///< x y z (motion), probe, bed.
  std::string covariate{};  ///< x y z t temp dir_x ... theta.
  double log_odds = 0;      ///< Against none, before anything was accepted [nats].
  std::string cause{};
  std::string axis{};
};

/// A finding against its covariate: errors in the sense of its channel, each row
/// divided by how the channel shows in it. Only rows that see the channel.
struct FindingSeries {
  std::string cause{};
  std::string axis{};
  std::string channel{};
  std::string covariate{};
  bool is_by_order = false;  ///< As in Finding.
  double period_mm = 0;      ///< A wave: `at` is folded by it. Else 0.
  std::vector<std::int64_t> rows{};
  std::vector<double> at{};         ///< Covariate, in its own unit.
  std::vector<double> before_um{};  ///< All other findings corrected, this one not.
  std::vector<double> after_um{};   ///< This one corrected too.
  /// By a second covariate, where the finding has one: class 0, 1 .. of each row.
  std::string split_by{};
  std::vector<int> split{};
  std::vector<std::string> split_labels{};
  double pure_error_um = 0;  ///< One sigma of these rows' readings.
};

/// How much a position differs by the sense it was reached in, the mean lost motion
/// (baseline) taken off: mean forward less mean backward.
struct DirectionContrast {
  std::string axis{};
  std::vector<double> at_mm{};
  std::vector<double> before_um{};
  std::vector<double> after_um{};
  double sd_um = 0;  ///< Of one contrast, from the readings' noise; the median.
};

/// What is left of a campaign against what its repeated readings scatter by. Left over
/// beyond the replicates: sqrt(rms^2 - pure error^2), what repeats but is not
/// explained.
struct LackOfFit {
  std::string campaign{};
  int rows = 0;
  int replicate_dof = 0;  ///< 0: nothing was repeated.
  /// Of one reading, from replicates, findings taken off; NaN: none.
  double pure_error_um = 0;
  double sigma_um = 0;   ///< As judged for the evidence, rms.
  double before_um = 0;  ///< rms left by the baseline.
  double after_um = 0;   ///< rms with the findings.
};

/// A row that somebody should look at.
struct FlaggedRow {
  std::int64_t row = 0;
  std::string campaign{};
  std::vector<double> cmd_mm{};  ///< NaN where unknown.
  double value_mm = 0;
  double left_um = 0;   ///< Reading less model with all findings.
  double sigmas = 0;    ///< The same in its own sigma.
  std::string flag{};   ///< The user's remark.
  bool is_out = false;  ///< Left out of every fit.
};

/// Everything that the pictures of a diagnosis draw: plain series.
struct PicturesData {
  std::vector<EvidenceCell> evidence_map{};
  std::vector<FindingSeries> findings{};  ///< In the diagnosis's order.
  std::vector<DirectionContrast> contrasts{};
  std::vector<Periodogram> periodograms{};
  std::vector<LackOfFit> lack_of_fit{};
  std::vector<FlaggedRow> flagged{};
};

/// @param as_read  the rows that `diagnosis` was made of
PicturesData PicturesDataOf(const Observed& as_read, const Diagnosis& diagnosis);

/// The map alone: the largest log odds by channel and covariate, in order of channel
/// (x y z probe bed), then of covariate.
std::vector<EvidenceCell> EvidenceMapOf(const std::vector<EvidenceLine>& weighed);

}  // namespace caltwin

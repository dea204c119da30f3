#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "calibration/diagnosis/diagnosis.h"
#include "calibration/diagnosis/observed.h"

namespace caltwin {

/// Which waves along one axis the rows hold, the baseline projected out.
///
///   residual = s sin(2 pi q / P) + c cos(2 pi q / P),   amplitude = hypot(s, c)
///
/// fitted for each period P together with the whole baseline and a bend (q^2, q^3), so
/// a wave that scale, reversal or an offset could imitate does not show. NaN where the
/// positions cannot tell a wave of that period from the baseline (regular spacing hides
/// every period that divides it).
struct Periodogram {
  std::string axis{};
  double lead_mm = 0;  ///< One turn of the screw, or of the pulley.
  bool is_belt = false;
  double four_full_steps_mm = 0;
  /// Descending: from half the span to the harmonics of a turn (lead / 4.5), then those
  /// about four full steps.
  std::vector<double> period_mm{};
  std::vector<double> before_um{};  ///< Amplitude in what the baseline leaves.
  std::vector<double> after_um{};   ///< The same with the findings fitted too.
  /// What noise alone reaches anywhere in one of a hundred such periodograms.
  double noise_um = 0;
};

/// None where the axis has too few positions along which motion was read.
std::optional<Periodogram> PeriodogramOf(const Observed& observed,
                                         const Diagnosis& diagnosis,
                                         Axis axis);

/// The period at which `before_um` is largest; 0 where nothing could be told.
double PeakPeriod_mm(const Periodogram& periodogram);

/// How many of its periods, the first ones, belong to turns; the rest lie about four
/// full steps.
std::size_t NumOfTurns(const Periodogram& periodogram);

}  // namespace caltwin

#pragma once

#include "sim/measure/row.h"
#include "sim/measure/rows.h"

namespace caltwin {

/// How trigger heights follow the temperatures of frame and bed, each felt by a part
/// that lags behind its thermometer:
///
///   value = c + frame (T_frame - T0)(lagged) + bed (T_bed - T0)(lagged)
///
/// Least squares; an account of the log, not a finding.
struct GrowthFit {
  double frame_mm_per_k = kUnknown;
  double bed_mm_per_k = kUnknown;
  double frame_lag_s = 0;
  double bed_lag_s = 0;
  double rms_mm = kUnknown;           ///< Of the readings fitted.
  double explained = 0;               ///< Part of their variance, 0 to 1.
  double held_out_rms_mm = kUnknown;  ///< Of blocks left out, one after the other.
};

/// Without lag, readings more than 20 median residuals off left out. Unknown of fewer
/// than ten readings.
GrowthFit PlainGrowth(const RowTable& table);

/// The same with both lags that fit best, up to two hours; `held_out_rms_mm` chooses
/// them anew for every block left out, of an hour or a twelfth of the log, whichever is
/// longer.
GrowthFit LaggedGrowth(const RowTable& table);

}  // namespace caltwin

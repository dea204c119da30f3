#pragma once

#include <array>
#include <vector>

#include <nlohmann/json.hpp>

#include "calibration/diagnosis/diagnosis.h"
#include "calibration/diagnosis/observed.h"
#include "sim/measure/row.h"

namespace caltwin {

/// What the fit says that readings at one place are off by, in the sense of `value_mm`:
/// of a gauge how far the moving part is off, of a touch how far the surface seems to
/// be.
struct ErrorAtPlace {
  RowKind kind = RowKind::kPosition;
  std::array<double, 3> cmd_mm{};  ///< NaN where nobody told.
  std::array<double, 3> n{};       ///< Unit vector along which it is off.
  int sense = 0;  ///< +1, -1: of the axis most along n, coming there; 0: not known.
  int rows = 0;
  double fitted_um = 0;  ///< Mean over its rows.
};

/// By place, direction and sense, in order of the rows, those left out not counted.
/// With findings: what they do beside the baseline. Without: what the baseline does to
/// a campaign, less its mean, which is where things lie. Empty where there are more
/// than a drawing can show.
std::vector<ErrorAtPlace> ErrorsByPlace(const Observed& as_read,
                                        const Diagnosis& diagnosis);

nlohmann::ordered_json ToJson(const std::vector<ErrorAtPlace>& errors);

}  // namespace caltwin

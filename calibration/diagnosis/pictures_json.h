#pragma once

#include <nlohmann/json.hpp>

#include "calibration/diagnosis/pictures_data.h"

namespace caltwin {

/// Every series that the pictures draw, as drawn: what `--report` writes beside them.
/// NaN becomes null.
nlohmann::ordered_json PicturesJson(const PicturesData& data);

/// The same without the long series (points by row and period), for `--json`: evidence
/// map, lack of fit, direction contrast, the highest peaks of each periodogram, flagged
/// rows.
nlohmann::ordered_json ShowJson(const PicturesData& data);

}  // namespace caltwin

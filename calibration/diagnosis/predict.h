#pragma once

#include <map>
#include <string>

#include "calibration/diagnosis/observed.h"

namespace caltwin {

/// What a model of one run says of another run of the same machine, nothing refitted
/// but where artefacts lie and which zero gauges have.
struct Prediction {
  double before_mm =
      0;  ///< rms of the rows, the machine as drawn (and the frozen baseline).
  double after_mm = 0;  ///< The same with the model's effects, as they were found.
  double floor_mm = kUnknown;  ///< Of repeats in this run; kUnknown: none.
  int rows = 0;
  int left_out = 0;        ///< Of these, bad by themselves whatever the model.
  bool transfers = false;  ///< after < two thirds of before.
};

/// `with`: these rows under the model; `without`: under what it extends. `baseline`:
/// lines of the model's baseline (scale, gap, pre-travel), held as they were found.
Prediction Predict(const Observed& without,
                   const Observed& with,
                   const std::map<std::string, double>& baseline);

}  // namespace caltwin

#pragma once

#include <string>
#include <vector>

#include "calibration/procedures/catalog.h"
#include "calibration/procedures/options.h"

namespace caltwin {

struct VerifyOptions {
  std::vector<Axis> axes{kAxes.begin(), kAxes.end()};
  std::string artefact{};
  std::vector<double> sizes_mm{25.4, 50.8, 76.2};
  int repeats = 3;
  std::string instrument = "dial";  ///< For the reversal: dial | laser | none.
  bool restart = false;             ///< M999 first: do the values survive?
  Place place{};
};

/// What the five checks of NeXT phase 5 found on one axis [mm], each with its limit.
struct Checks {
  double worst_size_mm = 0;     ///< 1: largest error of a size; 0.02.
  double compensated_mm = 0;    ///< M425, while the reversal was read.
  double reversal_mm = 0;       ///< 2: between approaches from both sides; 0.01.
  bool reversal_known = false;  ///< An instrument was there to tell.
  double scatter_mm = 0;        ///< 3: of ten touches; 0.005.
  double offset_mm = 0;         ///< 4: alike on every size: both directions; 0.01.
  double slope = 0;             ///< Error of a size in proportion to it.
  double pocket_mm = 0;         ///< 5: a feature that was not calibrated on; 0.02.
  bool pocket_known = false;
  double sd_mm = 0;  ///< Of one size.
};

/// Which calibration to revisit, in the guide's words; empty where all is well.
std::vector<std::string> WhatToRevisit(Axis axis, const Checks& checks);

/// NeXT phase 5: verifies all calibrations together.
Expected<void> RunVerify(Session* session, const VerifyOptions& options);

extern const Procedure kVerify;

}  // namespace caltwin

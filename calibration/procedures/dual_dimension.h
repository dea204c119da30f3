#pragma once

#include "calibration/procedures/catalog.h"
#include "calibration/procedures/options.h"

namespace caltwin {

struct DualDimensionOptions {
  CommonOptions common{};
  std::vector<double> sizes_mm{25.4, 76.2};  ///< The first and the last are compared.
  bool macro = false;                        ///< The guide's macro G9000 to the letter.
};

/// NeXT phase 2: steps/mm of one axis from two sizes of one block.
Expected<void> RunDualDimension(Session* session, const DualDimensionOptions& options);

extern const Procedure kDualDimension;

}  // namespace caltwin

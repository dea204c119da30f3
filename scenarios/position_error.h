#pragma once

#include <vector>

#include "sim/machine/axis.h"

namespace caltwin {

/// 95 % quantile of how far position errors [mm] lie from their mean: the size of what
/// no shift of the origin takes away. The quantile is that of the n errors by rank,
/// the n 95 / 100-th smallest; `errors_mm` has at least two.
double P95AboutMean_mm(const std::vector<Vec3<double>>& errors_mm);

}  // namespace caltwin

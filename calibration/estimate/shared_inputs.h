#pragma once

#include <span>
#include <string>
#include <vector>

#include "calibration/estimate/correlation.h"
#include "calibration/estimate/uncertain.h"

namespace caltwin {

/// A result by name, and what its uncertainty is made of.
struct Budgeted {
  std::string name{};
  std::vector<Contribution> budget{};
};

/// How results go together that were estimated one by one, by the inputs they share
/// (JCGM 100, F.1.2.3): with c_ik u_k what source k adds to result i, sign included,
///
///   r_ij = sum_k c_ik c_jk u_k^2 / (u_i u_j)
///
/// A source that is itself one of the results (a gap that was measured before) brings
/// along what that result stands on. What one fit told together (`fits`) stands as
/// told. Results that share nothing are left out; empty where none share.
Correlations SharedCorrelations(std::span<const Budgeted> results,
                                std::span<const Correlations> fits);

/// `fits`, and SharedCorrelations last where results share anything.
std::vector<Correlations> AllCorrelations(std::span<const Budgeted> results,
                                          std::vector<Correlations> fits);

}  // namespace caltwin

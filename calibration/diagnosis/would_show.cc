#include "calibration/diagnosis/would_show.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calibration/diagnosis/candidates.h"
#include "calibration/diagnosis/evidence.h"
#include "sim/base/dense.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kVisible_sigma = 10;
// Less than this part of an effect left by the baseline is rounding, not sight.
constexpr double kLeastLeft = 1e-6;
constexpr double kLeastSigma_mm = 1e-6;
constexpr double kSecondsPerHour = 3600;

}  // namespace

std::vector<WouldShow> WhatRowsWouldShow(const Observed& observed,
                                         const Diagnosis& diagnosis) {
  const double sigma_mm = std::max(diagnosis.gain.noise_floor_mm, kLeastSigma_mm);
  const Eigen::VectorXd sigmas_mm =
      Eigen::VectorXd::Constant(observed.num_rows(), sigma_mm);
  const double wander_mm = MmFromUm(diagnosis.wander_um_per_sqrt_h);
  const double wander_mm2_per_s = wander_mm * wander_mm / kSecondsPerHour;
  const Evidence evidence(
      observed, {sigmas_mm, wander_mm2_per_s}, BaselineOf(observed));
  const double least_mm = MmFromUm(diagnosis.min_effect_um);
  std::vector<WouldShow> all;
  for (const Candidate& candidate : AllCandidates(observed)) {
    if (candidate.is_free() || candidate.variants.empty()) continue;
    const Variant& middle = candidate.variants[candidate.variants.size() / 2];
    const Eigen::MatrixXd white = evidence.Whiten(middle.columns_mm);
    const double whole = white.squaredNorm();
    const double seen = EigenvaluesOf(evidence.Project(white).gram).minCoeff();
    all.push_back(
        {.cause = candidate.cause,
         .axis = candidate.axis,
         .smallest_mm = seen > kLeastLeft * whole
                            ? std::max(kVisible_sigma / std::sqrt(seen), least_mm)
                            : std::numeric_limits<double>::infinity()});
  }
  std::ranges::stable_sort(all, {}, &WouldShow::smallest_mm);
  return all;
}

}  // namespace caltwin

#include "calibration/diagnosis/baseline_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "calibration/diagnosis/evidence.h"
#include "calibration/diagnosis/kinds/diagnosed_kind.h"
#include "calibration/diagnosis/nuisances.h"
#include "sim/base/median.h"

namespace caltwin {
namespace {

// Rows further out than this many standard deviations of their campaign, as its median
// deviation tells them.
std::vector<bool> FarOut(const Observed& observed, const Eigen::VectorXd& left_mm) {
  constexpr double kFar = 5;
  std::vector<std::vector<double>> sizes_mm(observed.campaigns().size());
  const auto campaign = [&](Eigen::Index i) {
    return static_cast<std::size_t>(
        observed.campaign_of()[static_cast<std::size_t>(i)]);
  };
  for (Eigen::Index i = 0; i < left_mm.size(); ++i) {
    sizes_mm[campaign(i)].push_back(std::abs(left_mm[i]));
  }
  std::vector<double> sigma_mm;
  for (const auto& of_campaign : sizes_mm) {
    sigma_mm.push_back(kSigmaOfMedian * Median(of_campaign));
  }
  std::vector<bool> far(static_cast<std::size_t>(left_mm.size()));
  for (Eigen::Index i = 0; i < left_mm.size(); ++i) {
    far[static_cast<std::size_t>(i)] =
        std::abs(left_mm[i]) > kFar * sigma_mm[campaign(i)];
  }
  return far;
}

}  // namespace

FittedBaseline FitBaseline(const Observed& observed,
                           const std::vector<Nuisance>& found) {
  constexpr double kAnySigma_mm = 1e-3;
  constexpr double kSure = 2;                 // Standard deviations.
  constexpr double kMostPretravel_mm = 0.15;  // More of it is a wrong tip.
  constexpr int kRounds = 3;
  std::vector<Nuisance> baseline = BaselineOf(observed);
  const std::size_t num_own = baseline.size();
  baseline.insert(baseline.end(), found.begin(), found.end());
  const Noise noise{Eigen::VectorXd::Constant(observed.num_rows(), kAnySigma_mm), 0};
  Evidence::Fit fit;
  std::vector<bool> left_out;
  for (int round = 0; round < kRounds; ++round) {
    fit = Evidence(observed, noise, baseline, left_out).FitNuisances();
    left_out = FarOut(observed, fit.residual_mm);
  }
  const auto known = [&](const std::string& name) {
    const auto nuisance = std::ranges::find(baseline, name, &Nuisance::name);
    const auto k = nuisance - baseline.begin();
    if (nuisance == baseline.end()) return kUnknown;
    const double value = nuisance->offset + fit.values[k];
    return value > kSure * fit.sds[k] ? value : kUnknown;
  };
  FittedBaseline at{.left_mm = fit.residual_mm};
  const DiagnosedKind& kind = DiagnosedAs(observed.machine());
  if (kind.turns_build()) {
    at.point.turns = kind.Turned(
        observed.machine(), observed.turns(), {baseline.data(), num_own}, fit.values);
    return at;
  }
  for (const Axis axis : kAxes) {
    const DriveMap* drives = observed.machine().kind->drive_map();
    const double gap_mm = known("backlash." + DriveName(drives, Index(axis)));
    if (Known(gap_mm)) at.point.gap_mm[Index(axis)] = gap_mm;
    const double pretravel_mm = known("probe_pretravel." + Name(axis));
    if (pretravel_mm < kMostPretravel_mm) {
      at.point.pretravel_mm[Index(axis)] = pretravel_mm;
    }
  }
  return at;
}

Observed AtBaseline(const Observed& as_read, const std::vector<Nuisance>& found) {
  constexpr int kRounds = 3;
  Observed at = as_read.AtNominal();
  for (int round = 0; round < kRounds; ++round) {
    const FittedBaseline fit = FitBaseline(at, found);
    at = as_read.AtFitted(fit.left_mm, fit.point);
  }
  return at;
}

Observed TurnedBy(const Observed& as_read,
                  const Observed& at,
                  const std::vector<Nuisance>& baseline,
                  const Eigen::VectorXd& values,
                  const Eigen::VectorXd& left_mm) {
  const DiagnosedKind& kind = DiagnosedAs(at.machine());
  if (!kind.turns_build()) return at;
  return as_read.AtFitted(
      left_mm, {.turns = kind.Turned(at.machine(), at.turns(), baseline, values)});
}

bool AreApart(const Observed& one, const Observed& other) {
  constexpr double kPart = 0.05;
  const Vec3<double> moved_mm = one.pretravel_mm() - other.pretravel_mm();
  if ((moved_mm.cwiseQuotient(one.pretravel_mm()).cwiseAbs().array() > kPart).any()) {
    return true;
  }
  const std::vector<double> sds = DiagnosedAs(one.machine()).TurnSds();
  for (std::size_t k = 0; k < sds.size(); ++k) {
    const double moved = one.turns()[k] - other.turns()[k];
    if (std::abs(moved) > kPart * sds[k]) return true;
  }
  for (Eigen::Index i = 0; i < one.num_rows(); ++i) {
    if ((one.at(i).dir - other.at(i).dir).cwiseAbs().maxCoeff() > kPart) return true;
  }
  return false;
}

}  // namespace caltwin

#include "calibration/diagnosis/own_shape.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

constexpr const char* kJump = "missed_steps";
constexpr double kFree_mm = 30;
constexpr double kMostClose =
    0.04;  // Left of what is explained: a fifth of its height.

// The mean of the jumps from one place of their grid on, each with its weight: what is
// reached little by little.
Variant Smeared(const std::vector<Variant>& jumps,
                std::size_t first,
                const std::vector<double>& weights) {
  Variant variant = jumps[first];
  variant.columns_mm.setZero();
  double sum = 0;
  for (std::size_t k = 0; k < weights.size(); ++k) {
    variant.columns_mm += weights[k] * jumps[first + k].columns_mm;
    sum += weights[k];
  }
  variant.columns_mm /= sum;
  const double peak = std::max(Peak_mm(variant.columns_mm.col(0)), 1e-6);
  variant.columns_mm /= peak;
  variant.usual_mm *= peak;
  return variant;
}

// Ramps of several lengths at every place, and creeps of the same lengths.
std::vector<Variant> GradualOf(const std::vector<Variant>& jumps) {
  constexpr std::size_t kShortest = 8;
  constexpr double kTimeConstants = 3;
  std::vector<Variant> gradual;
  for (std::size_t length = kShortest; length <= jumps.size(); length *= 2) {
    const std::vector<double> ramp(length, 1.0);
    std::vector<double> creep;
    for (std::size_t k = 0; k < length; ++k) {
      creep.push_back(std::exp(-kTimeConstants * static_cast<double>(k) /
                               static_cast<double>(length)));
    }
    for (std::size_t first = 0; first + length <= jumps.size(); first += length / 4) {
      gradual.push_back(Smeared(jumps, first, ramp));
      gradual.push_back(Smeared(jumps, first, creep));
    }
  }
  return gradual;
}

std::ptrdiff_t KeptRows(const std::vector<bool>& left_out) {
  return std::max<std::ptrdiff_t>(1, std::ranges::count(left_out, false));
}

}  // namespace

PlainFit FitPlain(const Observed& observed,
                  const Circumstances& beside,
                  double wander_mm2_per_s,
                  const Eigen::MatrixXd& columns_mm,
                  const Eigen::VectorXd& sizes_mm) {
  constexpr double kShown = 0.2;  // Of the near-peak.
  const Noise noise{beside.sigma_mm, wander_mm2_per_s};
  const Evidence before(observed, noise, beside.nuisances, beside.left_out);
  std::vector<Nuisance> with = beside.nuisances;
  for (Eigen::Index k = 0; k < columns_mm.cols(); ++k) {
    with.push_back({.name = "shape",
                    .unit = "mm",
                    .column_mm = columns_mm.col(k),
                    .prior_sd = kFree_mm,
                    .reported = false});
  }
  const Evidence after(observed, noise, with, beside.left_out);
  const Eigen::VectorXd shown = before.Left(before.Whiten(columns_mm * sizes_mm));
  const Eigen::VectorXd without = before.Left(before.white_residual());
  const Eigen::VectorXd rest = after.Left(after.white_residual());
  const double noise2 = after.dof() / static_cast<double>(KeptRows(beside.left_out));
  const double least = kShown * Peak_mm(shown);
  PlainFit fit;
  double rows = 0;
  for (Eigen::Index i = 0; i < shown.size(); ++i) {
    if (std::abs(shown[i]) < least || beside.left_out[static_cast<std::size_t>(i)]) {
      continue;
    }
    fit.explained += without[i] * without[i] - rest[i] * rest[i];
    fit.left += rest[i] * rest[i] - noise2;
    ++rows;
  }
  fit.doubt = std::sqrt(2 * rows);
  return fit;
}

Form FormOf(const Candidate& candidate, const Machine& machine) {
  if (IsRigid(candidate)) return Form::kExact;
  const bool is_printer = machine.kind->touches_with_nozzle();
  return is_printer && candidate.shown.channel == "bed" ? Form::kClose : Form::kLike;
}

bool LeavesTooMuch(const PlainFit& fit, Form form) {
  constexpr double kVisible = 9;
  constexpr double kMostLike = 0.3;
  if (fit.explained < kVisible) return form == Form::kExact;
  const double most = form == Form::kLike ? kMostLike : kMostClose;
  return fit.left - fit.doubt > most * fit.explained;
}

bool IsProven(const PlainFit& fit, double shown_of_freedom) {
  const double part = std::min(1.0, shown_of_freedom);
  return fit.left + fit.doubt < kMostClose * part * part * fit.explained;
}

double ShownPart(const Observed& observed,
                 const Circumstances& beside,
                 const Eigen::VectorXd& change_mm) {
  const Evidence evidence(
      observed, {beside.sigma_mm, 0}, beside.nuisances, beside.left_out);
  const Eigen::VectorXd white = evidence.Whiten(change_mm);
  const double whole = white.norm();
  return whole > 0 ? evidence.Left(white).norm() / whole : 0;
}

bool IsBorrowed(const Observed& observed,
                const Circumstances& beside,
                const Candidate& candidate,
                const Weighed& weighed) {
  constexpr double kMostOfUsual = 10, kLeastShown = 0.05;
  const Variant& variant = candidate.variants[weighed.variant];
  const Eigen::VectorXd& sizes_mm = weighed.sizes_mm;
  // A wrong tip is large and hardly shows by its nature.
  const bool is_over_place = std::ranges::any_of(
      candidate.shown.covariates,
      [](const std::string& word) { return AxisNamed(word).has_value(); });
  return !candidate.is_free() && is_over_place &&
         sizes_mm.norm() > kMostOfUsual * variant.usual_mm &&
         ShownPart(observed, beside, variant.columns_mm * sizes_mm) < kLeastShown;
}

double GradualOdds(const Observed& observed,
                   const Circumstances& beside,
                   const Candidate& candidate) {
  constexpr double kNever = -std::numeric_limits<double>::infinity();
  if (candidate.cause != kJump) return kNever;
  Candidate gradual = candidate;
  gradual.variants = GradualOf(candidate.variants);
  if (gradual.variants.empty()) return kNever;
  const auto ranked = Weigh(observed, {candidate, gradual}, beside).ranked;
  const double first = ranked[0].log_odds - ranked[1].log_odds;
  return ranked[0].candidate == 1 ? first : -first;
}

bool IsAmongOutliers(const Observed& observed,
                     const std::vector<bool>& is_outlier,
                     const Candidate& candidate,
                     const Variant& variant) {
  if (candidate.cause != kJump) return false;
  constexpr std::size_t kRows = 20;  // On either side.
  constexpr int kMost = 4;           // One in ten.
  const double jump_s = variant.forms[0];
  std::vector<Eigen::Index> rows(static_cast<std::size_t>(observed.num_rows()));
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = static_cast<Eigen::Index>(i);
  std::ranges::stable_sort(
      rows, {}, [&](Eigen::Index i) { return observed.at(i).t_s; });
  const auto split = static_cast<std::size_t>(std::ranges::count_if(
      rows, [&](Eigen::Index i) { return observed.at(i).t_s < jump_s; }));
  const std::size_t first = split - std::min(split, kRows);
  const std::size_t last = std::min(split + kRows, rows.size());
  int outliers = 0;
  for (std::size_t k = first; k < last; ++k) {
    outliers += is_outlier[static_cast<std::size_t>(rows[k])] ? 1 : 0;
  }
  return outliers > kMost;
}

bool IsPlaceAsWell(const Observed& observed,
                   const Candidate& candidate,
                   const Variant& variant) {
  const auto axis = AxisNamed(candidate.shown.channel);
  if (candidate.cause != kJump || !axis) return false;
  constexpr double kAlong = 0.5;
  const double jump_s = variant.forms[0];
  double low_mm[2] = {1e300, 1e300}, high_mm[2] = {-1e300, -1e300};
  for (Eigen::Index i = 0; i < observed.num_rows(); ++i) {
    const At& at = observed.at(i);
    if (std::abs(at.n[Index(*axis)]) < kAlong) continue;
    const int side = at.t_s < jump_s ? 0 : 1;
    low_mm[side] = std::min(low_mm[side], at.q_mm[Index(*axis)]);
    high_mm[side] = std::max(high_mm[side], at.q_mm[Index(*axis)]);
  }
  const bool has_both = high_mm[0] >= low_mm[0] && high_mm[1] >= low_mm[1];
  return has_both && (high_mm[0] < low_mm[1] || high_mm[1] < low_mm[0]);
}

}  // namespace caltwin

#include "calibration/estimate/backlash.h"

#include <cmath>

#include "calibration/estimate/expanded.h"
#include "calibration/estimate/linear_fit.h"
#include "sim/base/require.h"

namespace caltwin {
namespace {

// Columns of the trigger/release fit: b, hysteresis [mm], 2 tau in units of a
// millisecond, so that all columns are of the order of a feed in mm/s or of 1.
constexpr double kLatencyUnit_s = 1e-3;

Uncertain Component(const LinearFit& fit, const Eigen::VectorXd& weights) {
  const bool told = (fit.blind.transpose() * weights).norm() < 1e-6;
  return {.value = weights.dot(fit.x),
          .sd = SdOf(weights, fit.covariance),
          .identifiable = told && fit.rank > 0};
}

// The same with its budget: x = C A^T r, so that each row, whitened, adds its own gain.
Uncertain Component(const LinearFit& fit,
                    const Eigen::MatrixXd& a,
                    const Eigen::VectorXd& weights,
                    std::span<const TriggerRelease> feeds,
                    const std::string& hysteresis_source) {
  Uncertain component = Component(fit, weights);
  if (!component.identifiable) return component;
  const Eigen::VectorXd gain = a * (fit.covariance * weights);
  std::vector<Contribution> budget;
  std::vector<Contribution> readings;
  for (Eigen::Index row = 0; const TriggerRelease& feed : feeds) {
    readings.push_back(
        InputOf("readings", gain[row++], {.sd = 1, .dof = feed.difference_mm.dof}));
  }
  const auto count = static_cast<Eigen::Index>(feeds.size());
  budget.push_back(
      {.input = "readings", .u = Expand(readings).u, .dof = EffectiveDof(readings)});
  budget.push_back(
      InputOf("hysteresis", gain[count], {.sd = 1, .source = hysteresis_source}));
  budget.push_back({.input = "latency", .u = std::abs(gain[count + 1])});
  return WithBudget(component.value, std::move(budget));
}

// A row of A and its right-hand side, divided by its standard deviation.
void AddRow(const Eigen::Vector3d& columns,
            const Given& value,
            Eigen::Index row,
            Eigen::MatrixXd* a,
            Eigen::VectorXd* r) {
  a->row(row) = columns.transpose() / value.sd;
  (*r)[row] = value.value / value.sd;
}

}  // namespace

ReleaseFit BacklashFromRelease(std::span<const TriggerRelease> feeds,
                               const Given& hysteresis_mm,
                               const Given& latency_s) {
  // What is known exactly is known to a hundredth of a nanometre and a nanosecond:
  // smaller than anything here, and a proper row.
  constexpr double kExact = 1e-8;
  const auto readings = static_cast<Eigen::Index>(feeds.size());
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(readings + 2, 3);
  Eigen::VectorXd r = Eigen::VectorXd::Zero(readings + 2);
  for (Eigen::Index row = 0; const TriggerRelease& feed : feeds) {
    Require(feed.difference_mm.sd > 0, "a reading has a standard deviation");
    const double late_mm = 2.0 * feed.feed_mm_s * kLatencyUnit_s;
    AddRow({1, 1.0, late_mm}, feed.difference_mm, row++, &a, &r);
  }
  if (std::isfinite(hysteresis_mm.sd)) {
    AddRow({0, 1, 0},
           {hysteresis_mm.value, std::max(hysteresis_mm.sd, kExact)},
           readings,
           &a,
           &r);
  }
  if (std::isfinite(latency_s.sd)) {
    AddRow({0, 0, 1},
           {latency_s.value / kLatencyUnit_s,
            std::max(latency_s.sd / kLatencyUnit_s, kExact)},
           readings + 1,
           &a,
           &r);
  }
  const LinearFit fit = SolveLinear(a, r, {.relative = 1e-12});

  Uncertain latency = Component(fit, Eigen::Vector3d(0, 0, 1));
  latency.value *= kLatencyUnit_s;
  latency.sd *= kLatencyUnit_s;
  const auto told = [&](const Eigen::Vector3d& of) {
    return Component(fit, a, of, feeds, hysteresis_mm.source);
  };
  return {.backlash_mm = told({1, 0, 0}),
          .latency_s = latency,
          .combination_mm = told({1, 1, 0}),
          .chi2_per_dof = fit.chi2_per_dof};
}

double TriggerReleaseSd_mm(const TouchNoise& noise, int pairs) {
  return std::sqrt(2.0) * MeanSd_mm(noise, pairs);
}

bool FrictionHoldsCarriage(Axis axis,
                           const AxisDrawing& drawing,
                           const ProbeDrawing& probe) {
  const double weight_n = drawing.moving_mass_kg * kGravity_m_s2;
  const double hanging_n =
      axis == Axis::kZ ? std::abs(weight_n - drawing.counterbalance_n) : 0;
  return drawing.rail_friction_n >
         probe.stiffness_n_per_mm * probe.pretravel_mm + hanging_n;
}

Uncertain BacklashFromApproaches(std::span<const double> plus_mm,
                                 std::span<const double> minus_mm,
                                 double reading_sd_mm) {
  if (plus_mm.empty() || minus_mm.empty()) return {};
  const double n_plus = static_cast<double>(plus_mm.size());
  const double n_minus = static_cast<double>(minus_mm.size());
  return {.value = Mean(minus_mm) - Mean(plus_mm),
          .sd = reading_sd_mm * std::sqrt(1 / n_plus + 1 / n_minus),
          .identifiable = true};
}

Uncertain BacklashFromDial(std::span<const double> readings_mm,
                           int sense,
                           double reading_sd_mm) {
  Require(sense == 1 || sense == -1, "a sense is +1 or -1");
  if (readings_mm.empty()) return {};
  const double count = static_cast<double>(readings_mm.size());
  const double each_sd_mm = std::sqrt(2.0) * reading_sd_mm;
  return {.value = sense * Mean(readings_mm),
          .sd = each_sd_mm / std::sqrt(count),
          .identifiable = true};
}

Uninformative SameSideBacklash(std::span<const double> first_mm,
                               std::span<const double> second_mm,
                               const TouchNoise& noise) {
  Uninformative result;
  if (first_mm.empty() || second_mm.empty()) return result;
  result.value_mm = std::abs(Mean(second_mm) - Mean(first_mm));
  result.sd_mm = std::hypot(MeanSd_mm(noise, static_cast<int>(first_mm.size())),
                            MeanSd_mm(noise, static_cast<int>(second_mm.size())));
  result.statement =
      "Both touches move in the same sense, so both stand on the same side of the gap: "
      "the two reversals between them cancel, and the difference holds no backlash "
      "whatever its size. Touch against release, or approach one position from both "
      "sides with a dial.";
  return result;
}

Uninformative AwayReturnBacklash(std::span<const double> readings_mm,
                                 double reading_sd_mm) {
  Uninformative result;
  if (readings_mm.empty()) return result;
  for (const double reading_mm : readings_mm) result.value_mm += std::abs(reading_mm);
  const double count = static_cast<double>(readings_mm.size());
  result.value_mm /= count;
  result.sd_mm = std::sqrt(2.0) * reading_sd_mm / std::sqrt(count);
  result.statement =
      "The dial was zeroed and read after moves in the same sense: away and back cross "
      "the gap twice, and the reading holds no backlash whatever its size. Preload and "
      "zero, go on in the same sense, then come back and read.";
  return result;
}

}  // namespace caltwin

#include "calibration/kinds/delta/engine_uncertainty.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "calibration/estimate/expanded.h"
#include "calibration/estimate/linear_fit.h"
#include "sim/machine/kinds/delta/knobs.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {
namespace {

const DeltaKnob& KnobAt(int knob) {
  return kDeltaKnobs[static_cast<std::size_t>(knob)];
}

// "rod_mismatch.a1", "bed_tilt.slope_x_mrad": the cause before the dot.
std::string CauseOf(int knob) {
  const std::string name(KnobAt(knob).name);
  return name.substr(0, name.find('.'));
}

std::vector<int> KnobsBeside(const std::vector<int>& moved) {
  std::vector<int> beside;
  for (int knob = 0; knob < kNumDeltaKnobs; ++knob) {
    if (std::ranges::find(moved, knob) == moved.end()) beside.push_back(knob);
  }
  return beside;
}

// Columns in units of what machines stray by, so that all are alike.
Eigen::VectorXd PriorsOf(const std::vector<int>& knobs,
                         const DeltaBuild<double>& drawn) {
  Eigen::VectorXd priors(std::ssize(knobs));
  std::ranges::transform(
      knobs, priors.begin(), [&](int knob) { return PriorSdOf(knob, drawn); });
  return priors;
}

// The engine moves an angle and not the twist that goes with it.
Eigen::VectorXd PriorsOfLacking(const std::vector<int>& lacking,
                                const HeightSquares& engine) {
  Eigen::VectorXd priors = PriorsOf(lacking, engine.drawn);
  for (Eigen::Index k = 0; k < priors.size(); ++k) {
    const int angle = lacking[static_cast<std::size_t>(k)] - kTwistKnob + kAngleKnob;
    if (!IsAngleKnob(angle) ||
        std::ranges::find(engine.knobs, angle) == engine.knobs.end())
      continue;
    priors[k] = std::hypot(
        priors[k], engine.drawn.twist_per_angle * PriorSdOf(angle, engine.drawn));
  }
  return priors;
}

Eigen::MatrixXd SlopesOf(const DeltaBuild<double>& build,
                         const HeightSquares& engine,
                         const std::vector<int>& knobs) {
  std::vector<Vec3<double>> motors_mm;
  for (const DeltaTouch& touch : engine.touches) motors_mm.push_back(touch.motors_mm);
  return HeightSlopes(build, motors_mm, knobs);
}

// One line a cause that the engine's model has not; `moved`: G B, in prior's units.
std::vector<Contribution> BudgetOfRow(const Eigen::VectorXd& moved,
                                      const std::vector<int>& lacking,
                                      double touches_u) {
  constexpr double kLittle = 1e-3;  // Of the variance.
  const double all = moved.squaredNorm() + touches_u * touches_u;
  std::map<std::string, double> causes;
  for (Eigen::Index k = 0; k < moved.size(); ++k) {
    double& u = causes[CauseOf(lacking[static_cast<std::size_t>(k)])];
    u = std::hypot(u, moved[k]);
  }
  std::vector<Contribution> budget{{.input = "touches", .u = touches_u}};
  double little = 0;
  for (const auto& [cause, u] : causes) {
    if (u * u >= kLittle * all) {
      budget.push_back({.input = cause + ", not in its model", .u = u});
    } else {
      little = std::hypot(little, u);
    }
  }
  if (little > 0) budget.push_back({.input = "all else not in its model", .u = little});
  return budget;
}

}  // namespace

EngineUncertainty UncertaintyOfHeightSquares(const DeltaModel<double>& found,
                                             const HeightSquares& engine) {
  const Eigen::VectorXd reach = PriorsOf(engine.knobs, engine.drawn);
  const Eigen::MatrixXd a =
      SlopesOf({.model = found}, engine, engine.knobs) * reach.asDiagonal();
  const Eigen::VectorXd sigmas_mm = [&] {
    Eigen::VectorXd sigmas(std::ssize(engine.touches));
    for (Eigen::Index i = 0; i < sigmas.size(); ++i) {
      sigmas[i] = engine.touches[static_cast<std::size_t>(i)].sigma_mm;
    }
    return sigmas;
  }();
  const LinearFit fit = SolveLinear(a, Eigen::VectorXd::Zero(a.rows()));
  if (!fit.identifiable || !a.allFinite()) return {};
  const Eigen::MatrixXd gain = fit.covariance * a.transpose();
  const std::vector<int> lacking = KnobsBeside(engine.knobs);
  const Eigen::MatrixXd noise = gain * sigmas_mm.asDiagonal();
  DeltaBuild<double> build = engine.drawn;
  build.model = found;
  const Eigen::MatrixXd moved = gain * SlopesOf(build, engine, lacking) *
                                PriorsOfLacking(lacking, engine).asDiagonal();
  EngineUncertainty told;
  std::vector<std::string> names;
  for (std::size_t k = 0; k < engine.knobs.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    const DeltaKnob& knob = KnobAt(engine.knobs[k]);
    const double per_unit = knob.per_unit / reach[row];
    const Uncertain sure = WithBudget(
        0,
        BudgetOfRow(
            moved.row(row) / per_unit, lacking, noise.row(row).norm() / per_unit));
    told.estimates.push_back({.name = std::string(knob.name),
                              .unit = std::string(knob.unit),
                              .sd = sure.sd,
                              .identifiable = true,
                              .is_setting = true,
                              .budget = sure.budget});
    names.emplace_back(knob.name);
  }
  told.correlations = {
      CorrelationsOf(engine.procedure,
                     std::move(names),
                     noise * noise.transpose() + moved * moved.transpose())};
  return told;
}

std::vector<Correlations> CorrelationsOfDelta(const DeltaJointFit& fit) {
  std::vector<Eigen::Index> at;
  std::vector<std::string> names;
  for (std::size_t k = 0; k < fit.estimates.size(); ++k) {
    if (fit.estimates[k].sd_over_prior >= kDeltaNotTold) continue;
    at.push_back(static_cast<Eigen::Index>(k));
    names.emplace_back(KnobAt(fit.estimates[k].knob).name);
  }
  if (names.size() < 2) return {};
  return {CorrelationsOf("delta_joint", std::move(names), fit.covariance(at, at))};
}

}  // namespace caltwin

#include "calibration/procedures/joint_uncertainty.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "calibration/estimate/expanded.h"
#include "calibration/estimate/touch_noise.h"
#include "calibration/procedures/scale_doubt.h"

namespace caltwin {
namespace {

Uncertain AsUncertain(const JointEstimate& estimate) {
  return {.value = estimate.value,
          .sd = estimate.sd,
          .identifiable = estimate.identifiable,
          .budget = estimate.budget};
}

// Of an axis whose steps/mm are estimated here the fit itself knows how sure they are.
Given ScaleBeside(Session* session, const JointOptions& o, Axis axis) {
  const bool is_estimated = std::ranges::find(o.axes, axis) != o.axes.end();
  return is_estimated ? Given{.value = 1} : ScaleOf(session, axis, o.steps_doubt);
}

// Slopes of the table, read in millimetres of axes that may not be among the unknowns.
Uncertain TiltWithDoubt(Session* session,
                        const JointOptions& o,
                        const std::string& name,
                        const Uncertain& slope) {
  if (!name.starts_with("bed_tilt.slope_")) return slope;
  const Axis along = name.starts_with("bed_tilt.slope_x") ? Axis::kX : Axis::kY;
  return WithScaleDoubt(
      slope, ScaleBeside(session, o, along), ScaleBeside(session, o, Axis::kZ));
}

// Doubts of steps/mm that slopes are read in add to their variances; that of z to both,
// so to what they have in common too.
void AddSlopeDoubts(Session* session,
                    const JointOptions& o,
                    const std::vector<JointEstimate>& told,
                    Eigen::MatrixXd* covariance) {
  const double z_doubt = ScaleBeside(session, o, Axis::kZ).sd;
  const auto along = [](const JointEstimate& estimate) -> std::optional<Axis> {
    if (!estimate.name.starts_with("bed_tilt.slope_")) return std::nullopt;
    return estimate.name.starts_with("bed_tilt.slope_x") ? Axis::kX : Axis::kY;
  };
  for (std::size_t i = 0; i < told.size(); ++i) {
    const auto axis = along(told[i]);
    if (!axis) continue;
    const auto row = static_cast<Eigen::Index>(i);
    (*covariance)(row, row) +=
        std::pow(told[i].value * ScaleBeside(session, o, *axis).sd, 2);
    for (std::size_t j = 0; j < told.size(); ++j) {
      if (!along(told[j])) continue;
      (*covariance)(row, static_cast<Eigen::Index>(j)) +=
          told[i].value * told[j].value * z_doubt * z_doubt;
    }
  }
}

}  // namespace

void ConcludeCorrelations(Session* session,
                          const JointOptions& o,
                          const JointFit& fit) {
  std::vector<Eigen::Index> at;
  std::vector<JointEstimate> told;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < fit.estimates.size(); ++i) {
    const JointEstimate& estimate = fit.estimates[i];
    if (estimate.is_nuisance || !estimate.identifiable) continue;
    at.push_back(static_cast<Eigen::Index>(i));
    told.push_back(estimate);
    names.push_back(estimate.name);
  }
  Eigen::MatrixXd covariance = fit.covariance(at, at);
  AddSlopeDoubts(session, o, told, &covariance);
  session->Correlate(std::move(names), covariance);
}

void ConcludeAll(Session* session,
                 const JointOptions& o,
                 const JointFit& fit,
                 const std::array<bool, 3>& applied) {
  for (const JointEstimate& estimate : fit.estimates) {
    if (estimate.is_nuisance) continue;
    const auto axis = AxisNamed(estimate.name.substr(estimate.name.size() - 1));
    const bool has_setting = estimate.name.starts_with("steps_per_mm.") ||
                             estimate.name.starts_with("backlash.") ||
                             estimate.name.starts_with("probe_pretravel.");
    const bool is_setting = has_setting && axis && estimate.identifiable &&
                            applied[static_cast<std::size_t>(Index(*axis))];
    session->Conclude(estimate.name,
                      estimate.unit,
                      TiltWithDoubt(session, o, estimate.name, AsUncertain(estimate)),
                      is_setting);
  }
}

void BelieveScatter(Session* session, JointFit* fit) {
  const double factor =
      ScatterFactor(fit->chi2_per_dof, static_cast<int>(std::lround(fit->dof)));
  if (factor <= 1) return;
  const int dof = static_cast<int>(std::lround(fit->dof));
  for (JointEstimate& estimate : fit->estimates) {
    estimate.sd *= factor;
    estimate.budget = {InputOf("the readings' own scatter",
                               1,
                               {.sd = estimate.sd, .dof = static_cast<double>(dof)})};
  }
  fit->covariance *= factor * factor;
  session->Tell(fmt::format(
      "The readings do not fit as their noise allows (chi2 per dof {:.1f}): "
      "every uncertainty is {:.1f} times as large. A touch on an edge, dirt, "
      "or an error that the model does not have.",
      fit->chi2_per_dof,
      factor));
}

void TakeRobust(Session* session, JointOptions::Scatter scatter, JointFit* fit) {
  const bool by_rows = scatter == JointOptions::Scatter::kRows;
  const Eigen::MatrixXd& robust = by_rows ? fit->hc3_covariance : fit->group_covariance;
  const double dof = by_rows ? fit->dof : fit->num_groups - 1;
  for (std::size_t i = 0; i < fit->estimates.size(); ++i) {
    JointEstimate& estimate = fit->estimates[i];
    const auto at = static_cast<Eigen::Index>(i);
    const Uncertain told =
        WithBudget(estimate.value,
                   {{.input = by_rows ? "rows' own residuals" : "faces' own residuals",
                     .u = std::sqrt(robust(at, at)),
                     .dof = std::max(1.0, dof)}});
    estimate.sd = told.sd;
    estimate.budget = told.budget;
  }
  fit->covariance = robust;
  session->Tell(fmt::format(
      "Uncertainties are those of the residuals, {} (robust covariance, {:.0f} degrees "
      "of freedom), not of the noise stated.",
      by_rows ? "row by row" : "face by face",
      dof));
}

}  // namespace caltwin

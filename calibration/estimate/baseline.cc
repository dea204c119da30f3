#include "calibration/estimate/baseline.h"

#include <algorithm>
#include <cmath>

#include "sim/base/units.h"
#include "sim/effects/catalog.h"

namespace caltwin {
namespace {

// For rows that state no sigma: any number does, the residuals then scale the sds.
constexpr double kAssumedSigma_mm = 0.001;

// An axis with home at 0 and no weight on its nut, so that scale is a slope through 0
// and the vertical axis has its reversal too.
Machine PlainMachine() {
  Machine machine;
  for (AxisDrawing& drawing : machine.axes) {
    drawing.counterbalance_n = drawing.moving_mass_kg * kGravity_m_s2;
  }
  for (const Axis axis : kAxes) {
    machine.settings.steps_per_mm[static_cast<std::size_t>(Index(axis))] =
        machine.axis(axis).steps_per_mm();
  }
  machine.settings.tip_radius_mm = machine.probe.tip_radius_mm;
  return machine;
}

struct Measured {
  bool gauge = false;
  bool touch = false;
};

Measured HowMeasured(const std::vector<Observation>& observations, Axis axis) {
  Measured measured;
  for (const Observation& observation : observations) {
    if (observation.at.n[Index(axis)] == 0) continue;
    const bool touch = observation.at.kind == RowKind::kTouch;
    (touch ? measured.touch : measured.gauge) = true;
  }
  return measured;
}

void AddAxis(Axis axis,
             const Measured& measured,
             const BaselineOptions& options,
             JointProblem* problem) {
  if (options.scale) {
    problem->free.push_back(
        {.effect = EffectIndex<StepsPerMm>(), .axis = Name(axis), .prior = kNotGiven});
  }
  if (options.reversal) {
    // Touches tell backlash and pre-travel only together: beliefs split the sum.
    FreeParameter backlash{.effect = EffectIndex<Backlash>(), .axis = Name(axis)};
    if (!measured.touch) backlash.prior = kNotGiven;
    problem->free.push_back(backlash);
  }
  if (measured.touch) {
    problem->free.push_back(
        {.effect = EffectIndex<ProbePretravel>(), .axis = Name(axis)});
  }
}

// Steps/mm as the axis' scale error: moved / commanded - 1 = s_cfg / s_true - 1.
void ToScale(const Machine& machine, Axis axis, BaselineValue* value) {
  const double configured =
      machine.settings.steps_per_mm[static_cast<std::size_t>(Index(axis))];
  const double ratio = configured / value->value;
  value->sd = PpmFromFraction(ratio * value->sd / value->value);
  value->value = PpmFromFraction(ratio - 1);
  value->name = "scale." + Name(axis);
  value->unit = "ppm";
}

}  // namespace

const BaselineValue* BaselineFit::Find(std::string_view name) const {
  const auto found = std::ranges::find(values, name, &BaselineValue::name);
  return found == values.end() ? nullptr : &*found;
}

BaselineFit FitBaseline(const RowTable& table, const BaselineOptions& options) {
  JointProblem problem{.machine = options.machine != nullptr ? *options.machine
                                                             : PlainMachine()};
  problem.observations = ObservationsOf(
      table,
      problem.machine,
      {.settings = options.settings, .default_sigma_mm = kAssumedSigma_mm});
  for (const Axis axis : kAxes) {
    const Measured measured = HowMeasured(problem.observations, axis);
    if (measured.gauge || measured.touch) AddAxis(axis, measured, options, &problem);
  }
  const JointFit joint = FitJoint(problem);

  BaselineFit fit{.residuals_mm = joint.residuals_mm,
                  .rms_mm = joint.rms_mm,
                  .dof = joint.dof,
                  .converged = joint.converged,
                  .observability = joint.observability};
  const bool all_stated = std::ranges::all_of(
      table.rows, [](const Row& row) { return Known(row.sigma_mm); });
  if (!all_stated || joint.chi2_per_dof > 1) {
    fit.sd_factor = std::sqrt(joint.chi2_per_dof);
  }
  for (const JointEstimate& estimate : joint.estimates) {
    BaselineValue value{.name = estimate.name,
                        .unit = estimate.unit,
                        .value = estimate.value,
                        .sd = estimate.sd * fit.sd_factor,
                        .identifiable = estimate.identifiable};
    for (const Axis axis : kAxes) {
      if (value.name == "steps_per_mm." + Name(axis)) {
        ToScale(problem.machine, axis, &value);
      }
    }
    fit.values.push_back(std::move(value));
  }
  return fit;
}

}  // namespace caltwin

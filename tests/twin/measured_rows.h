#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <variant>
#include <vector>

#include "sim/base/units.h"
#include "sim/effects/catalog.h"
#include "sim/effects/predict.h"
#include "sim/kinds/perform.h"
#include "sim/measure/plan.h"

namespace caltwin {

inline Machine Gantry() {
  return ReadMachine("models/gantry_router/machine.yaml");
}

/// Every effect that a cartesian machine may have.
inline std::vector<int> EffectsOfAGantry() {
  std::vector<int> effects;
  for (int i = 0; i < static_cast<int>(kNumEffects); ++i) {
    if (!EffectAt(i).axes.empty()) effects.push_back(i);
  }
  return effects;
}

/// Few rows in which every effect shows somewhere: both senses, all faces, two loads,
/// feeds, offsets and spindle orientations, warm and cold, circles.
inline PlannedSession SomeOfEverything() {
  const Plan plan = ReadPlanText(R"(
seed: 3
campaigns:
  - drift: {duration_s: 1200, interval_s: 600, warm_up_k: 20}
  - iso230: {axis: x, positions: 4, runs: 1, loads_n: [8, 30]}
  - dense: {axis: x, periods: 0.5, points_per_period: 24}
  - iso230: {axis: y, positions: 3, runs: 1}
  - iso230: {axis: z, positions: 3, runs: 1}
  - ring: {points: 5, spindle_deg: [0, 70]}
  - plate: {grid: [3, 2], repeats: 1, probe_offset_mm: [0, 30], feeds_mm_s: [1, 4]}
  - plate_turned_90: {grid: [2, 2], repeats: 1}
  - blocks: {points: 1, ways: 1, feeds_mm_s: [2]}
  - rehoming: {homings: 2, repeats: 1}
  - ballbar: {points: 8, feeds_mm_s: [30], radius_mm: 90}
)",
                                 "some_of_everything.yaml");
  return PlanSession(plan, Gantry(), plan.seed);
}

/// A standard deviation of what is expected of a size, so that a wrong act shows while
/// second-order terms (2 mrad tilt 135 mm: 0.27 um) stay below what is claimed.
inline double LargeValue(const Parameter& parameter) {
  struct Large {
    double operator()(double value) const { return value; }
    double operator()(const Normal& n) const { return n.mean + n.sd; }
    double operator()(const Uniform& u) const { return u.min + 0.7 * (u.max - u.min); }
    double operator()(const LogNormal& l) const { return l.median * l.factor; }
  };
  return std::clamp(std::visit(Large{}, parameter.prior), parameter.min, parameter.max);
}

inline Injected LargeEffect(int effect, std::string_view axis, const Machine& machine) {
  Injected injected = NeutralEffect(effect, axis, machine);
  if (axis == kAnyAxis) injected.axis = "block123";
  const auto& parameters = EffectAt(effect).parameters;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    injected.values[i] = LargeValue(parameters[i]);
  }
  // Within the first homing session of SomeOfEverything.
  if (effect == EffectIndex<MissedSteps>()) injected.values[1] = 400;
  return injected;
}

/// What the closed form leaves out: a drive that winds up gives way to the stylus'
/// spring too, which pushes back at the trigger with stiffness times pre-travel.
inline double Neglected_mm(const Injected& effect,
                           const Row& row,
                           const Machine& machine) {
  if (effect.effect != EffectIndex<WindupLoad>() || row.kind != RowKind::kTouch)
    return 0;
  constexpr double kStylusDamping_n_s_per_mm = 0.03;
  const double pushed_n =
      machine.probe.stiffness_n_per_mm * machine.probe.pretravel_mm +
      kStylusDamping_n_s_per_mm * row.feed_mm_s;
  return MmFromUm(effect.values[0]) * pushed_n / 2;
}

/// What the twin reads, without noise and rounding.
inline std::vector<double> Read_mm(const PlannedSession& session,
                                   const std::vector<Injected>& effects,
                                   Fidelity fidelity,
                                   const Machine& machine = Gantry()) {
  const RowTable table = Perform({.machine = machine,
                                  .effects = effects,
                                  .header = session.header,
                                  .fidelity = fidelity,
                                  .is_noisy = false},
                                 session.rows);
  std::vector<double> values_mm;
  for (const Row& row : table.rows) values_mm.push_back(row.value_mm);
  return values_mm;
}

}  // namespace caltwin

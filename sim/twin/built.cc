#include "sim/twin/built.h"

#include <algorithm>
#include <cmath>

#include "sim/base/mutant.h"
#include "sim/base/units.h"
#include "sim/effects/injected.h"
#include "sim/machine/disc_overlap.h"

namespace caltwin {

namespace {

// A hanging load pulls the carriage to one side: through the gap where friction cannot
// hold it, and by the load over the stiffness (2 / c) of the drive.
Vec3<double> LagCenter_mm(const Machine& machine,
                          const std::vector<Injected>& effects) {
  const AxisDrawing& z = machine.axis(Axis::kZ);
  const double load_n = z.moving_mass_kg * kGravity_m_s2 - z.counterbalance_n;
  const double gap_mm = BuiltValue(machine, effects, EffectIndex<Backlash>(), "z", 0);
  const double compliance_mm_per_n =
      MmFromUm(BuiltValue(machine, effects, EffectIndex<WindupLoad>(), "z", 0));
  double lag_mm = -load_n * compliance_mm_per_n / 2;
  if (WeightKeepsGapShut(Axis::kZ, z)) lag_mm -= std::copysign(gap_mm / 2, load_n);
  return {0, 0, lag_mm};
}

}  // namespace

double LagAfter_mm(double lag_mm, double travel_mm, double width_mm) {
  const double half_mm = width_mm / Mutant("play_operator_whole_width", 2.0, 1.0);
  return std::clamp(lag_mm - travel_mm, -half_mm, half_mm);
}

void Built::Prepare() {
  for (const Axis axis : kAxes) {
    steps_per_mm[Index(axis)] =
        BuiltValue(machine, effects, EffectIndex<StepsPerMm>(), Name(axis), 0);
  }
  probe = ErrorsAt<double>(machine, At{.steps_per_mm = steps_per_mm}, effects);
  lost_motion_mm = probe.lost_motion_mm;
  lag_center_mm = LagCenter_mm(machine, effects);
  table_effects.clear();
  for (const Injected& effect : effects) {
    if (EffectAt(effect.effect).stage == Stage::kArtefact)
      table_effects.push_back(effect);
  }
  solids = {TableOf(machine)};
  for (const Artefact& artefact : artefacts) {
    const auto parts = SolidsOf(artefact);
    solids.insert(solids.end(), parts.begin(), parts.end());
  }
  solids_for_disc = solids;
  for (Solid& solid : solids_for_disc) {
    const double grown_mm = machine.probe.disc_radius_mm - probe.tip_radius_mm;
    solid.half_mm.head<2>().array() += grown_mm;
    if (solid.bore_radius_mm > 0) solid.bore_radius_mm -= grown_mm;
  }
}

Vec3<double> Built::Motors_mm(const Vec3<double>& steps) const {
  Vec3<double> motors_mm = steps.cwiseQuotient(steps_per_mm);
  for (const Axis axis : kAxes) motors_mm[Index(axis)] += machine.axis(axis).home_mm();
  return motors_mm;
}

Vec3<double> Built::StepsAt(const Vec3<double>& motors_mm) const {
  Vec3<double> travel_mm = motors_mm;
  for (const Axis axis : kAxes) travel_mm[Index(axis)] -= machine.axis(axis).home_mm();
  return travel_mm.cwiseProduct(steps_per_mm);
}

Vec3<double> Built::Tip_mm(const Vec3<double>& steps,
                           const Vec3<double>& lag_mm) const {
  At at{.kind = RowKind::kPosition};
  for (const Axis axis : kAxes) {
    const int i = Index(axis);
    const AxisDrawing& drawing = machine.axis(axis);
    at.steps_per_mm[i] = drawing.steps_per_mm();
    at.q_mm[i] = drawing.home_mm() + steps[i] / at.steps_per_mm[i];
    const double off_mm = lag_mm[i] - lag_center_mm[i];
    at.dir[i] = lost_motion_mm[i] > 0 ? -2 * off_mm / lost_motion_mm[i] : 0;
  }
  return at.q_mm + lag_center_mm + ErrorsAt<double>(machine, at, effects).motion_mm;
}

SurfaceDistance Built::Clearance(const Vec3<double>& tip_mm) const {
  const bool is_disc = stylus == Stylus::kDisc;
  SurfaceDistance nearest = NearestOf(is_disc ? solids_for_disc : solids, tip_mm);
  const bool is_flat = is_disc && std::abs(nearest.normal[2]) == 1;
  nearest.distance_mm -=
      probe.tip_radius_mm +
      (is_flat ? TableUnderDisc_mm(tip_mm, nearest) : Table_mm(tip_mm, nearest.normal));
  return nearest;
}

double Built::Table_mm(const Vec3<double>& p_mm, const Vec3<double>& normal) const {
  if (table_effects.empty()) return 0;
  const At at{.q_mm = p_mm, .n = normal, .on_table = true};
  return ErrorsAt<double>(machine, at, table_effects).artefact_mm;
}

double Built::TableUnderDisc_mm(const Vec3<double>& p_mm,
                                const SurfaceDistance& nearest) const {
  const double here_mm = Table_mm(p_mm, nearest.normal);
  const Eigen::Vector2d uphill(
      Table_mm(p_mm + Unit(Axis::kX), nearest.normal) - here_mm,
      Table_mm(p_mm + Unit(Axis::kY), nearest.normal) - here_mm);
  const Solid& solid = solids[nearest.solid];
  const Eigen::Vector2d contact_mm =
      FirstContact_mm({.disc_mm = p_mm.head<2>(),
                       .radius_mm = machine.probe.disc_radius_mm,
                       .face_mm = solid.center_mm.head<2>(),
                       .half_mm = solid.half_mm.head<2>()},
                      uphill);
  return here_mm + uphill.dot(contact_mm - p_mm.head<2>());
}

double Built::scatter_mm() const {
  return std::sqrt(probe.scatter_mm2 + probe_sigma_mm * probe_sigma_mm);
}

}  // namespace caltwin

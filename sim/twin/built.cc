#include "sim/twin/built.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/base/units.h"
#include "sim/effects/acts/acts.h"
#include "sim/effects/acts/artefacts.h"
#include "sim/effects/injected.h"
#include "sim/machine/disc_overlap.h"

namespace caltwin {
namespace {

constexpr double kInverted_mm = 1e-9;

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

ActKind KindOfAct(const Injected& effect) {
  return AllActs()[static_cast<std::size_t>(effect.effect)].kind;
}

// Raises what is touched while the machine runs, or (a tilt) stands in the model.
bool ActsOnTable(const Injected& effect) {
  if (effect.effect == EffectIndex<FrameTemperature>()) return effect.axis == "bed";
  if (effect.effect == EffectIndex<UnknownMap>()) return effect.axis.starts_with("bed");
  return EffectAt(effect.effect).stage == Stage::kArtefact &&
         KindOfAct(effect) != ActKind::kArtefactMap;
}

// Effects whose closed form leaves the tool where it stands: summing them up at every
// place would change nothing. All else counts as moving it.
bool LeavesToolAlone(const Injected& effect) {
  static const std::array kSuch = {EffectIndex<ProbePretravel>(),
                                   EffectIndex<TipSize>(),
                                   EffectIndex<TriggerLatency>(),
                                   EffectIndex<TriggerScatter>(),
                                   EffectIndex<BedTilt>(),
                                   EffectIndex<BedBowl>(),
                                   EffectIndex<BedCylinder>(),
                                   EffectIndex<BedTwist>(),
                                   EffectIndex<BlockSize>(),
                                   EffectIndex<BlockRotated>()};
  return std::ranges::find(kSuch, effect.effect) != kSuch.end();
}

}  // namespace

double LagAfter_mm(double lag_mm, double travel_mm, double width_mm) {
  const double half_mm = width_mm / 2.0;
  return std::clamp(lag_mm - travel_mm, -half_mm, half_mm);
}

void Built::Prepare() {
  if (drives() != nullptr && !now.drives) {
    now.drives = DrivesAt{.map = drives(), .home_mm = DrivesHome_mm()};
  }
  for (int i = 0; i < 3; ++i) {
    steps_per_mm[i] = BuiltValue(
        machine, effects, EffectIndex<StepsPerMm>(), DriveName(drives(), i), 0);
  }
  drive_effects.clear();
  frame_effects.clear();
  tool_effects.clear();
  table_effects.clear();
  raising_effects.clear();
  surface_effects.clear();
  std::vector<Injected> everywhere;
  for (const Injected& effect : effects) {
    const ActKind kind = KindOfAct(effect);
    if (kind == ActKind::kDriveMap && effect.effect != EffectIndex<StepsPerMm>()) {
      drive_effects.push_back(effect);
    } else {
      everywhere.push_back(effect);
    }
    if (!LeavesToolAlone(effect)) {
      if (EffectAt(effect.effect).stage != Stage::kDrive) {
        frame_effects.push_back(effect);
      }
      // Without links, what would turn a delta's parts (a belt's pitch) moves the tool.
      const bool moves_tool =
          kind == ActKind::kReadingMap || kind == ActKind::kLinkBuild;
      if (moves_tool) tool_effects.push_back(effect);
    }
    if (kind == ActKind::kArtefactMap) surface_effects.push_back(effect);
    if (!ActsOnTable(effect)) continue;
    table_effects.push_back(effect);
    if (kind == ActKind::kEditModel) continue;
    raising_effects.push_back(effect);
    surface_effects.push_back(effect);
  }
  probe = ErrorsAt<double>(machine, At{.steps_per_mm = steps_per_mm}, everywhere);
  lost_motion_mm = probe.lost_motion_mm;
  lag_center_mm = LagCenter_mm(machine, effects);
  standing = BuiltArtefacts(artefacts, effects);
  solids = {TableOf(machine)};
  for (const Artefact& artefact : standing) {
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

At Built::AtAxes(const Vec3<double>& q_mm) const {
  At at = now;
  at.q_mm = q_mm;
  for (int i = 0; i < 3; ++i) {
    if (!Known(at.since_rev_mm[i]))
      at.since_rev_mm[i] = std::abs(q_mm[i] - turned_at_mm[i]);
  }
  return at;
}

Vec3<double> Built::DrivesHome_mm() const {
  Vec3<double> home_mm;
  for (const Axis axis : kAxes) home_mm[Index(axis)] = machine.axis(axis).home_mm();
  return DrivesOf(drives(), home_mm);
}

Vec3<double> Built::Drawn_mm(const Vec3<double>& steps) const {
  Vec3<double> drives_mm = DrivesHome_mm();
  for (const Axis axis : kAxes) {
    const int i = Index(axis);
    drives_mm[i] += steps[i] / machine.axis(axis).steps_per_mm();
  }
  return AxesOf(drives(), drives_mm);
}

Vec3<double> Built::DriveBend_mm(const Vec3<double>& q_mm) const {
  if (drive_effects.empty()) return Vec3<double>::Zero();
  At at = AtAxes(q_mm);
  at.steps_per_mm.setZero();
  at.compensation_mm.setZero();
  const auto errors = ErrorsAt<double>(machine, at, drive_effects);
  // Without the play, which is the carriage's.
  const Vec3<double> taken_mm = TakenByPlay_mm(at, errors.lost_motion_mm);
  return DrivesOf(drives(), errors.motion_mm + taken_mm);
}

Vec3<double> Built::LocalLostMotion_mm(const Vec3<double>& q_mm) const {
  if (drive_effects.empty()) return Vec3<double>::Zero();
  return ErrorsAt<double>(machine, AtAxes(q_mm), drive_effects).lost_motion_mm;
}

Vec3<double> Built::LostMotion_mm(const Vec3<double>& q_mm) const {
  return lost_motion_mm + LocalLostMotion_mm(q_mm);
}

Vec3<double> Built::ToolOffset_mm(const Vec3<double>& q_mm) const {
  if (tool_effects.empty()) return now.probe_off_mm;
  At at = AtAxes(q_mm);
  at.steps_per_mm.setZero();
  at.compensation_mm.setZero();
  return now.probe_off_mm + ErrorsAt<double>(machine, at, tool_effects).motion_mm;
}

double Built::Pretravel_mm(const Vec3<double>& normal) const {
  const double plain_mm = caltwin::Pretravel_mm(probe, normal);
  if (tool_effects.empty()) return plain_mm;
  At at = now;
  at.n = normal;
  return plain_mm + ErrorsAt<double>(machine, at, tool_effects).more_pretravel_mm;
}

Vec3<double> Built::Motors_mm(const Vec3<double>& steps) const {
  Vec3<double> motors_mm = steps.cwiseQuotient(steps_per_mm);
  motors_mm += DrivesHome_mm();
  if (drive_effects.empty()) return motors_mm;
  return motors_mm + DriveBend_mm(Drawn_mm(steps));
}

Vec3<double> Built::StepsAt(const Vec3<double>& motors_mm) const {
  Vec3<double> steps = Vec3<double>::Zero();
  constexpr int kMostRounds = 100;
  for (int i = 0; i < kMostRounds; ++i) {
    const Vec3<double> off_mm = motors_mm - Motors_mm(steps);
    steps += off_mm.cwiseProduct(steps_per_mm);
    if (off_mm.cwiseAbs().maxCoeff() < kInverted_mm) break;
  }
  return steps;
}

Vec3<double> Built::LagAt_mm(const Vec3<double>& from_lag_mm,
                             const Vec3<double>& from_steps,
                             const Vec3<double>& to_steps) const {
  const Vec3<double> travel_mm = (to_steps - from_steps).cwiseQuotient(steps_per_mm);
  const Vec3<double> play_mm = LostMotion_mm(Drawn_mm(to_steps));
  Vec3<double> lag_mm;
  for (int i = 0; i < 3; ++i) {
    lag_mm[i] =
        lag_center_mm[i] +
        LagAfter_mm(from_lag_mm[i] - lag_center_mm[i], travel_mm[i], play_mm[i]);
  }
  return lag_mm;
}

Vec3<double> Built::Tip_mm(const Vec3<double>& steps,
                           const Vec3<double>& lag_mm) const {
  const Vec3<double> axes_mm = AxesOf(drives(), Motors_mm(steps) + lag_mm);
  if (frame_effects.empty()) return axes_mm + now.probe_off_mm;
  At at = AtAxes(axes_mm);
  at.steps_per_mm.setZero();
  at.compensation_mm.setZero();
  return at.Tip_mm() + ErrorsAt<double>(machine, at, frame_effects).motion_mm;
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
  At at = now;
  at.q_mm = p_mm - at.probe_off_mm;
  at.n = normal;
  return ErrorsAt<double>(machine, at, table_effects).artefact_mm;
}

double Built::Raised_mm(const Vec3<double>& p_mm) const {
  At at = now;
  at.q_mm = p_mm - at.probe_off_mm;
  at.n = Vec3<double>::UnitZ();
  return ErrorsAt<double>(machine, at, raising_effects).artefact_mm;
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

#include "sim/kinds/triple_z/machine.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "sim/base/require.h"
#include "sim/effects/predict.h"
#include "sim/machine/kinds/triple_z/drawing.h"

namespace caltwin {
namespace {

constexpr double kTimestep_s = 1e-3;
constexpr double kSlowest_mm_s = 0.3;
constexpr double kFastest_mm_s = 10;  // Faster, MuJoCo sees the bed too late.
constexpr double kStart_mm = 0.25;    // Within the contact's gap.
constexpr double kMostTravel_mm = 3;  // Beyond where the closed form expects it.
constexpr double kApart_mm = 0.5;     // Of the points that tell a slope.

}  // namespace

Pivots<double> BuiltPivots_mm(const Machine& machine,
                              const std::vector<Injected>& effects) {
  Pivots<double> pivots_mm = TripleZOf(machine).pivots_mm();
  for (const Injected& effect : effects) {
    if (effect.effect != EffectIndex<PivotPosition>()) continue;
    auto& pivot_mm = pivots_mm[static_cast<std::size_t>(*ScrewNamed(effect.axis))];
    pivot_mm += Eigen::Vector2d(effect.values[0], effect.values[1]);
  }
  return pivots_mm;
}

TripleZWorld WorldOfTripleZ(const Machine& machine,
                            const Pivots<double>& pivots_mm,
                            bool with_looks,
                            double held_mm2) {
  TripleZMjcf model = TripleZMjcf::FromFile(
      machine.model.empty() ? ShareFolder() / "models/triple_z_printer/model.xml"
                            : machine.model);
  model.SetTimestep_s(kTimestep_s);
  model.SetPivots(pivots_mm);
  if (held_mm2 > 0) {
    model.LetScrewsGive(TripleZWorld::kNut_kg, TripleZWorld::kNutDamping_n_s_per_m);
  }
  return {model.Compile(with_looks), pivots_mm, held_mm2};
}

TripleZMachine::TripleZMachine(const Machine& machine,
                               const std::vector<Injected>& effects)
    : machine_(machine), effects_(effects) {
  Require(machine.Own<TripleZDrawing>() != nullptr,
          "the machine's bed stands on screws");
  double held_mm2 = 0;
  for (const Injected& effect : effects) {
    const Stage stage = EffectAt(effect.effect).stage;
    if (effect.effect == EffectIndex<PivotPosition>()) {
      build_.push_back(effect);
    } else if (effect.effect == EffectIndex<OverconstrainedBed>()) {
      build_.push_back(effect);
      held_mm2 += effect.values[0];
    } else if (stage == Stage::kDrive) {
      drives_.push_back(effect);
    } else if (stage == Stage::kFrame) {
      gantry_.push_back(effect);
    }
    // A table without a cause may be the bed's.
    if (stage == Stage::kArtefact || effect.effect == EffectIndex<UnknownMap>()) {
      surface_.push_back(effect);
    }
  }
  pivots_mm_ = BuiltPivots_mm(machine, effects);
  world_ = std::make_unique<TripleZWorld>(
      WorldOfTripleZ(machine, pivots_mm_, /*with_looks=*/false, held_mm2));
}

// Told heights, and what each screw does beside: swaps and scale among its errors.
Vec3<double> TripleZMachine::Nuts_mm(const At& at) const {
  const auto errors = ErrorsAt<double>(machine_, at, drives_);
  Vec3<double> nuts_mm =
      *ScrewsOf_mm(at) + ScrewsMoved_mm(at.screws->motor_dir, errors);
  // A gap that all share: the nozzle lags the bed's sense turned round.
  const double lost_mm = errors.lost_motion_mm[2] - at.compensation_mm[2];
  nuts_mm.array() += at.dir[2] * lost_mm / 2;
  return nuts_mm;
}

Vec3<double> TripleZMachine::Tip_mm(const At& at) const {
  Errors<double> errors;
  if (!at.screws->is_fixed) {
    for (const Injected& effect : gantry_) {
      const Asked<double> asked{.p = effect.values,
                                .axis = effect.axis,
                                .machine = machine_,
                                .at = at,
                                .q_mm = at.q_mm};
      AddErrors(effect.effect, asked, &errors);
    }
  }
  // What moves the nozzle along x and y, as belts do it.
  if (at.drives) {
    errors.motion_mm.head<2>() +=
        ErrorsAt<double>(machine_, at, drives_).motion_mm.head<2>();
  }
  Vec3<double> tip_mm = at.Tip_mm() + errors.motion_mm;
  tip_mm[2] = TripleZOf(machine_).top_mm + errors.motion_mm[2];
  return tip_mm;
}

double TripleZMachine::SurfaceAt_mm(At at, double dx_mm, double dy_mm) const {
  at.q_mm[0] += dx_mm;
  at.q_mm[1] += dy_mm;
  return ErrorsAt<double>(machine_, at, surface_).artefact_mm;
}

BedSpot TripleZMachine::SpotAt(const At& at) const {
  const double half_mm = kApart_mm / 2;
  // What is touched ends where the row says: a plate is so much thicker than nothing.
  const double nominal_mm = at.screws->stated_z_mm + at.probe_off_mm[2];
  return {.at_mm = Tip_mm(at).head<2>(),
          .height_mm = nominal_mm + SurfaceAt_mm(at, 0, 0),
          .slope_x = (SurfaceAt_mm(at, half_mm, 0) - SurfaceAt_mm(at, -half_mm, 0)) /
                     kApart_mm,
          .slope_y = (SurfaceAt_mm(at, 0, half_mm) - SurfaceAt_mm(at, 0, -half_mm)) /
                     kApart_mm};
}

double TripleZMachine::Gauge_mm(const At& at) {
  const Vec3<double> nuts_mm = Nuts_mm(at);
  const Vec3<double> tip_mm = Tip_mm(at);
  world_->Place(nuts_mm, /*speed_mm_s=*/0);
  for (int i = 0; i < world_->settle_steps(); ++i) world_->Step(nuts_mm);
  const double over_mm =
      tip_mm[2] - world_->Plane_mm(tip_mm.head<2>()) - SurfaceAt_mm(at, 0, 0);
  Vec3<double> off_mm = tip_mm - at.Tip_mm();
  off_mm[2] = over_mm - at.q_mm[2];
  return off_mm.dot(at.n);
}

// Where the bed has risen by `give_mm` since contact: the probe gives way by that.
double TripleZMachine::AfterContact_mm(const At& nominal,
                                       double contact_mm,
                                       double give_mm) const {
  constexpr int kRounds =
      5;  // Each leaves the wave's slope, some percent, of the last.
  const Vec3<double> weights =
      BuiltWeights(nominal, ErrorsAt<double>(machine_, nominal, build_));
  const auto bed_mm = [&](double value_mm) {
    At at = nominal;
    at.q_mm[2] += value_mm;
    return weights.dot(Nuts_mm(at));
  };
  const double at_contact_mm = bed_mm(contact_mm);
  double value_mm = contact_mm - give_mm;
  for (int i = 0; i < kRounds; ++i) {
    value_mm -= give_mm - (bed_mm(value_mm) - at_contact_mm);
  }
  return value_mm;
}

double TripleZMachine::Touch_mm(const Row& row, const At& nominal) {
  // Where contact is expected; what gives way before the trigger comes after it.
  const auto errors = ErrorsAt<double>(machine_, nominal, effects_);
  const double feed_mm_s = nominal.feed_mm_s;
  const double give_mm = Pretravel_mm(errors, nominal.n) + errors.more_pretravel_mm;
  const double late_mm = feed_mm_s * errors.latency_s;
  const double expected_mm = Value_mm(nominal, errors) + give_mm + late_mm;
  const double step_mm = std::clamp(std::abs(feed_mm_s), kSlowest_mm_s, kFastest_mm_s) *
                         world_->timestep_s();
  const auto at_mm = [&](double value_mm) {
    At at = nominal;
    at.q_mm[2] += value_mm;
    return at;
  };
  // The lowest point of the ball that the centre carries; of a flat nozzle, itself.
  world_->HangNozzle(Tip_mm(nominal) -
                     machine_.probe.tip_radius_mm * Vec3<double>::UnitZ());
  world_->SetSpot(SpotAt(nominal));
  double above_mm = expected_mm + kStart_mm + world_->settle_steps() * step_mm;
  world_->Place(Nuts_mm(at_mm(above_mm)), step_mm / world_->timestep_s());
  std::optional<double> before_mm;
  while (above_mm > expected_mm - kMostTravel_mm) {
    world_->Step(Nuts_mm(at_mm(above_mm - step_mm)));
    // A contact is found where the step began.
    const auto left_mm = world_->Clearance_mm();
    if (left_mm && *left_mm <= 0) {
      if (!before_mm) break;
      const double part = *before_mm / (*before_mm - *left_mm);
      const double contact_mm = above_mm + step_mm * (1 - part);
      return AfterContact_mm(nominal, contact_mm, give_mm) - late_mm;
    }
    before_mm = left_mm;
    above_mm -= step_mm;
  }
  throw InputError(
      row.place,
      fmt::format("row {}: the simulated bed never meets the nozzle there", row.row),
      "are the errors in mm, and the screws as the file has them?");
}

}  // namespace caltwin

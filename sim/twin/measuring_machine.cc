#include "sim/twin/measuring_machine.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "sim/base/units.h"
#include "sim/effects/acts/acts.h"
#include "sim/effects/drive.h"
#include "sim/effects/gap_sense.h"
#include "sim/effects/injected.h"
#include "sim/effects/surroundings.h"
#include "sim/twin/built_world.h"

namespace caltwin {
namespace {

constexpr double kTimestep_s = 2e-4;
constexpr double kReadingFeed_mm_s = 2;
// Ways to a reading: the next where a gap was not taken up on the one before.
constexpr std::array kWays_mm = {0.1, 0.5, 3.0};
constexpr int kStepsWatched = 20;
// Of a way's end over which a carriage may still fall behind its nut.
constexpr double kFallsBehind = 0.1;
// A touch is simulated at its own feed within these: slower costs time and changes
// nothing, faster the step of 0.2 ms no longer resolves a stylus of 0.02 mm.
constexpr double kSlowest_mm_s = 0.3;
constexpr double kFastest_mm_s = 20;
constexpr int kStepsBeforeContact = 60;
constexpr double kLeastBeforeContact_mm = 0.02;
constexpr double kStandOff_mm = 1;
constexpr double kFarthestSeen_mm = 1000;
constexpr double kOnTable_mm = 1e-3;
constexpr int kMostAims = 10;
constexpr double kMostTravel_mm = 8;
constexpr double kPushedIn_mm = 0.02;  // Beyond the trigger, before a release.
constexpr double kAlong = 1e-6;        // Part of n below which an axis does not move.

Vec3<double> NominalOf(const Row& row, const Machine& machine) {
  Vec3<double> nominal_mm;
  for (const Axis axis : kAxes) {
    const auto k = static_cast<std::size_t>(Index(axis));
    nominal_mm[Index(axis)] =
        Known(row.cmd_mm[k]) ? row.cmd_mm[k] : machine.axis(axis).mid_mm();
  }
  return nominal_mm;
}

[[noreturn]] void FailNoTrigger(const Row& row) {
  throw InputError(
      row.place,
      fmt::format("row {}: the probe of the simulated machine finds no surface within "
                  "{} mm",
                  row.row,
                  kMostTravel_mm),
      "is the model's probe able to move and to touch, and are the errors in mm?");
}

}  // namespace

MeasuringMachine::MeasuringMachine(const Machine& machine,
                                   const std::vector<Injected>& effects)
    : built_{.machine = machine, .effects = effects} {
  built_.Prepare();
  Mjcf model = ModelOf(machine);
  EditModel(machine, effects, &model);
  model.AddTarget();
  model.SetTimestep_s(kTimestep_s);
  world_ = std::make_unique<World>(model.Compile(/*with_looks=*/false),
                                   HangingLoad_n(machine));
  for (const Axis axis : kAxes) drawn_gap_mm_[Index(axis)] = world_->Gap_mm(axis);
  gap_mm_ = drawn_gap_mm_;
}

// The circumstances of one reading: gaps, friction, tool. `sense`: in which each axis
// comes; 0 leaves it in the middle of its gap.
void MeasuringMachine::Prepare(const At& at, const Vec3<double>& sense) {
  built_.now = at;
  for (int i = 0; i < 3; ++i) told_dir_[i] = DriveSense(at, i);
  const Machine& machine = built_.machine;
  Vec3<double> play_mm =
      ErrorsAt<double>(machine, built_.AtAxes(at.q_mm), built_.effects).lost_motion_mm;
  const Vec3<double> local_mm = built_.LocalLostMotion_mm(at.q_mm);
  for (const Axis axis : kAxes) {
    const int i = Index(axis);
    const AxisDrawing& drawing = machine.axis(axis);
    const double gap_mm = sense[i] == 0 ? 0 : drawn_gap_mm_[i] + local_mm[i];
    if (gap_mm != gap_mm_[i]) world_->SetGap_mm(axis, gap_mm);
    gap_mm_[i] = gap_mm;
    world_->SetRailFriction_n(axis,
                              Known(at.load_n) ? at.load_n : drawing.rail_friction_n);
    if (WeightKeepsGapShut(axis, drawing)) continue;
    play_mm[i] += drawn_gap_mm_[i] - BuiltValue(machine,
                                                built_.effects,
                                                EffectIndex<Backlash>(),
                                                DriveName(built_.drives(), i),
                                                0);
  }
  built_.now.dir = GapSense(at, play_mm);
  for (int i = 0; i < 3; ++i) {
    crossed_mm_[i] = std::numeric_limits<double>::infinity();
    lag_mm_[i] = built_.lag_center_mm[i] - sense[i] * play_mm[i] / 2;
    if (built_.now.dir[i] == at.dir[i]) continue;
    crossed_mm_[i] = at.since_rev_mm[i] + at.compensation_mm[i];
    lag_mm_[i] += sense[i] * (play_mm[i] - crossed_mm_[i]);
  }
  world_->MoveTool_mm(built_.ToolOffset_mm(at.q_mm));
}

// Where the motors put the nuts. The machine was homed as it hangs, so that counts from
// there.
Vec3<double> MeasuringMachine::Nuts_mm(const Vec3<double>& q_mm) const {
  const At& at = built_.now;
  const Vec3<double> drives_mm = DrivesOf(built_.drives(), q_mm);
  const Vec3<double> homes_mm = built_.DrivesHome_mm();
  Vec3<double> nuts_mm = built_.DriveBend_mm(q_mm) - built_.lag_center_mm;
  for (int i = 0; i < 3; ++i) {
    const double home_mm = homes_mm[i];
    const double travel_mm =
        drives_mm[i] - home_mm + told_dir_[i] * at.compensation_mm[i] / 2;
    nuts_mm[i] += home_mm + travel_mm * at.steps_per_mm[i] / built_.steps_per_mm[i];
  }
  return nuts_mm;
}

// To where the row has the axes, each from `way_mm` before it; of one within its gap
// from where it left the other side, if that is nearer.
MeasuringMachine::Way MeasuringMachine::WayOf(const At& at,
                                              const Vec3<double>& sense,
                                              double way_mm) const {
  Way way;
  for (int i = 0; i < 3; ++i) {
    way.feed_mm_s[i] =
        kReadingFeed_mm_s * sense[i] * std::min(1.0, crossed_mm_[i] / way_mm);
  }
  way.feed_mm_s = AxesOf(built_.drives(), way.feed_mm_s);
  way.from_mm = at.q_mm - way_mm / kReadingFeed_mm_s * way.feed_mm_s;
  return way;
}

// A carriage whose nut is within its gap stands, as it will in the end.
void MeasuringMachine::Stand(const Way& way) {
  const Vec3<double> nuts_mm = Nuts_mm(way.from_mm);
  const Vec3<double> end_nuts_mm = Nuts_mm(built_.now.q_mm);
  const Vec3<double> nuts_mm_s = DrivesOf(built_.drives(), way.feed_mm_s);
  Vec3<double> carriages_mm = nuts_mm + lag_mm_;
  Vec3<double> carriages_mm_s = nuts_mm_s;
  for (int i = 0; i < 3; ++i) {
    if (std::isinf(crossed_mm_[i])) continue;
    carriages_mm[i] = end_nuts_mm[i] + lag_mm_[i];
    carriages_mm_s[i] = 0;
  }
  world_->Place(nuts_mm,
                AxesOf(built_.drives(), carriages_mm),
                nuts_mm_s,
                AxesOf(built_.drives(), carriages_mm_s));
}

Vec3<double> MeasuringMachine::Lag_mm() const {
  return DrivesOf(built_.drives(), world_->Carriages_mm()) - world_->Nuts_mm();
}

void MeasuringMachine::Step(const Way& way, int step) {
  world_->Step(Nuts_mm(way.At(step * kTimestep_s)));
}

// Goes the whole way; whether the carriages keep up with their nuts at its end.
bool MeasuringMachine::GoesSteadily(const Way& way, int steps) {
  Stand(way);
  Vec3<double> lag_before_mm = Vec3<double>::Zero();
  for (int i = 1; i <= steps; ++i) {
    Step(way, i);
    if (i == steps - kStepsWatched) lag_before_mm = Lag_mm();
  }
  Vec3<double> behind_mm = (Lag_mm() - lag_before_mm).cwiseAbs();
  for (int i = 0; i < 3; ++i) {
    if (!std::isinf(crossed_mm_[i])) behind_mm[i] = 0;
  }
  return behind_mm.maxCoeff() <=
         kFallsBehind * kStepsWatched * kTimestep_s * kReadingFeed_mm_s;
}

double MeasuringMachine::Position_mm(const At& at) {
  Vec3<double> sense;
  for (int i = 0; i < 3; ++i) {
    const double told = DriveSense(at, i);
    sense[i] = told == 0 ? 0 : std::copysign(1, told);
  }
  Prepare(at, sense);
  world_->TouchTable();
  for (const double way_mm : kWays_mm) {
    const int steps =
        static_cast<int>(std::lround(way_mm / (kReadingFeed_mm_s * kTimestep_s)));
    if (GoesSteadily(WayOf(at, sense, way_mm), steps)) break;
  }
  return (world_->Tip_mm() - at.Tip_mm()).dot(at.n);
}

// Stands the surface where the row says: a block on the table, or, for a point of the
// table itself, what a person has put there.
void MeasuringMachine::Aim(const Row& row, const At& at) {
  const Vec3<double> nominal_mm = NominalOf(row, built_.machine);
  const Vec3<double> middle_mm(built_.machine.axis(Axis::kX).mid_mm(),
                               built_.machine.axis(Axis::kY).mid_mm(),
                               0);
  const double out_mm =
      ErrorsAt<double>(built_.machine, built_.AtAxes(at.q_mm), built_.surface_effects)
          .artefact_mm;
  if (world_->has_table_shape() && at.n[2] > 1 - kAlong &&
      std::abs(nominal_mm[2]) < kOnTable_mm) {
    world_->TurnTable(middle_mm + out_mm * at.n, RadFromDeg(at.artefact_turn_deg));
    world_->TouchTable();
    if (world_->Clearance_mm(kFarthestSeen_mm) < 2 * kMostTravel_mm) return;
  }
  world_->TurnTable(middle_mm, 0);
  world_->PlaceTarget(nominal_mm + out_mm * at.n, at.n);
}

// Stands the machine just before contact, the gaps taken up, moving towards it. How far
// that is MuJoCo's geometry tells.
MeasuringMachine::Way MeasuringMachine::Approach(const At& at, double feed_mm_s) {
  const double near_mm =
      std::max(kLeastBeforeContact_mm, kStepsBeforeContact * kTimestep_s * feed_mm_s);
  Way way{.from_mm = at.q_mm + kStandOff_mm * at.n, .feed_mm_s = -feed_mm_s * at.n};
  for (int i = 0; i < kMostAims; ++i) {
    Stand(way);
    const double off_mm = world_->Clearance_mm(kFarthestSeen_mm) - near_mm;
    if (std::abs(off_mm) < near_mm / 10) break;
    way.from_mm -= off_mm * at.n;
  }
  return way;
}

double MeasuringMachine::TriggerTime_s(const Row& row,
                                       const Way& way,
                                       double threshold_mm) {
  const int most = static_cast<int>(
      std::lround(kMostTravel_mm / way.feed_mm_s.norm() / kTimestep_s));
  double before_mm = -threshold_mm;
  for (int i = 1; i <= most; ++i) {
    Step(way, i);
    const double beyond_mm = world_->Deflection_mm().norm() - threshold_mm;
    if (beyond_mm >= 0) {
      return kTimestep_s * (i - beyond_mm / (beyond_mm - before_mm));
    }
    before_mm = beyond_mm;
  }
  FailNoTrigger(row);
}

// Time on the way out at which the switch closes again.
double MeasuringMachine::ReleaseTime_s(const Row& row,
                                       const Way& way,
                                       double threshold_mm) {
  const int most = static_cast<int>(
      std::lround(kMostTravel_mm / way.feed_mm_s.norm() / kTimestep_s));
  double before_mm = world_->Deflection_mm().norm() - threshold_mm;
  for (int i = 1; i <= most; ++i) {
    Step(way, i);
    const double left_mm = world_->Deflection_mm().norm() - threshold_mm;
    if (left_mm <= 0) return kTimestep_s * (i - left_mm / (left_mm - before_mm));
    before_mm = left_mm;
  }
  FailNoTrigger(row);
}

double MeasuringMachine::Touch_mm(const Row& row, const At& at) {
  const bool is_release = IsRelease(row);
  Vec3<double> sense;
  const Vec3<double> towards = -DrivesOf(built_.drives(), at.n);
  for (int i = 0; i < 3; ++i) {
    const bool moves = std::abs(towards[i]) > kAlong;
    const double told = DriveSense(at, i);
    sense[i] = told == 0 ? 0 : std::copysign(1, moves ? towards[i] : told);
  }
  Prepare(at, sense);
  Aim(row, at);
  const double told_mm_s = std::abs(at.feed_mm_s);
  const double feed_mm_s =
      std::clamp(told_mm_s > 0 ? told_mm_s : built_.machine.probe.speeds_mm_s.back(),
                 kSlowest_mm_s,
                 kFastest_mm_s);
  const Way in = Approach(at, feed_mm_s);
  const double threshold_mm = built_.Pretravel_mm(at.n);
  double q_off_mm =
      0;  // Of the axes at the trigger from the approach's start, along n.
  const double in_s = TriggerTime_s(row, in, threshold_mm);
  q_off_mm = -feed_mm_s * in_s;
  if (is_release) {
    const int pushed =
        static_cast<int>(std::lround((in_s + kPushedIn_mm / feed_mm_s) / kTimestep_s));
    for (int i = static_cast<int>(in_s / kTimestep_s) + 2; i <= pushed; ++i)
      Step(in, i);
    const Way out{.from_mm = in.At(pushed * kTimestep_s),
                  .feed_mm_s = feed_mm_s * at.n};
    const double out_s =
        ReleaseTime_s(row, out, threshold_mm - built_.machine.probe.hysteresis_mm);
    q_off_mm = -feed_mm_s * (pushed * kTimestep_s - out_s);
  }
  const double latency_mm = at.feed_mm_s * built_.probe.latency_s;
  const Vec3<double> tip_mm =
      in.from_mm + (q_off_mm - latency_mm) * at.n + at.probe_off_mm;
  return (tip_mm - NominalOf(row, built_.machine)).dot(at.n) - at.tip_radius_cfg_mm;
}

}  // namespace caltwin

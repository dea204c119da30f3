#include "sim/kinds/triple_z/plant.h"

#include <algorithm>
#include <cmath>

#include "sim/base/input_error.h"
#include "sim/effects/predict.h"
#include "sim/effects/surroundings.h"
#include "sim/kinds/perform.h"
#include "sim/machine/kinds/triple_z/drawing.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

// The touch of the bed's nominal point, as a row has it: coming from below.
Row TouchRow(const Machine& machine,
             const Vec3<double>& raised_mm,
             const Eigen::Vector2d& at_mm) {
  Row row{.kind = RowKind::kTouch};
  row.cmd_mm = {at_mm[0], at_mm[1], 0};
  row.n = {0, 0, 1};
  row.dir = {0, 0, -1};
  row.feed_mm_s = machine.probe.speeds_mm_s.back();
  row.feature = "bed.top";
  const ScrewCells screws = ScrewCellsOf(&row, machine.kind->drive_map() != nullptr);
  for (int i = 0; i < kNumScrews; ++i) {
    (*screws.mm)[static_cast<std::size_t>(i)] =
        TripleZOf(machine).top_mm + raised_mm[i];
  }
  screws.dir->fill(1);
  return row;
}

}  // namespace

TripleZTwinPlant::TripleZTwinPlant(const BuiltTripleZ& built,
                                   bool is_physics,
                                   std::uint64_t seed,
                                   std::uint64_t sample)
    : built_(built),
      scatter_(seed, sample, "trigger_scatter"),
      steps_(Motors::Zero(2 + kNumScrews)) {
  if (is_physics) {
    machine_ = std::make_unique<TripleZMachine>(built.machine, built.effects);
  }
}

TripleZTwinPlant::Stand TripleZTwinPlant::StandAt(const Motors& steps) const {
  const Machine& machine = built_.machine;
  const DriveMap* const map = machine.kind->drive_map();
  const auto& steps_per_mm = machine.settings.steps_per_mm;
  Vec3<double> home_mm = Vec3<double>::Zero();
  for (const Axis axis : {Axis::kX, Axis::kY}) {
    home_mm[Index(axis)] = machine.axis(axis).home_mm();
  }
  Vec3<double> drives_mm = DrivesOf(map, home_mm);
  for (int i = 0; i < 2; ++i) drives_mm[i] += steps[i] / steps_per_mm[i];
  Stand stand{.head_mm = AxesOf(map, drives_mm).head<2>(),
              .screws_mm = -steps.tail<kNumScrews>() / steps_per_mm[2]};
  const TripleZDrawing& drawing = TripleZOf(machine);
  const Vec3<double> weights =
      ScrewWeights<double>(drawing.pivots_mm(), stand.head_mm[0], stand.head_mm[1]);
  const double bed_mm = weights.dot(stand.screws_mm);
  stand.nozzle_mm = drawing.top_mm - bed_mm;
  stand.raised_mm = stand.screws_mm.array() - bed_mm;
  return stand;
}

double TripleZTwinPlant::BeforeHome_mm(Axis axis, const Stand& stand) const {
  const AxisDrawing& drawing = built_.machine.axis(axis);
  const double off_mm = stand.head_mm[Index(axis)] - drawing.home_mm();
  return drawing.home == HomeEnd::kMin ? off_mm : -off_mm;
}

bool TripleZTwinPlant::SwitchClosed(Axis axis) {
  const Stand stand = StandAt(steps_);
  return axis == Axis::kZ ? stand.screws_mm.maxCoeff() <= 0
                          : BeforeHome_mm(axis, stand) <= 0;
}

bool TripleZTwinPlant::ProbeTriggered() {
  if (is_triggered_) return true;
  const Stand stand = StandAt(steps_);
  return stand.nozzle_mm < TrueBedHeight_mm(built_, stand.raised_mm, stand.head_mm);
}

std::optional<TripleZTwinPlant::Trigger> TripleZTwinPlant::TriggerAt(const Stand& stand,
                                                                     double feed_mm_s) {
  const Machine& machine = built_.machine;
  Row row = TouchRow(machine, stand.raised_mm, stand.head_mm);
  row.feed_mm_s = feed_mm_s;
  const At at = AtOf(row, machine, machine.settings);
  double height_mm = 0;
  if (machine_) {
    try {
      height_mm = machine_->Touch_mm(row, at);
    } catch (const InputError&) {
      return std::nullopt;
    }
  } else {
    height_mm = ClosedFormTouch_mm(machine, built_.effects, row, at);
  }
  const double variance_mm2 = built_.scatter_mm * built_.scatter_mm +
                              ErrorsAt<double>(machine, at, built_.effects).scatter_mm2;
  return Trigger{.height_mm = height_mm, .scatter_mm = std::sqrt(variance_mm2)};
}

bool TripleZTwinPlant::ProbeActs(const Stand& stand) {
  // Beyond it nothing has to be looked at closely.
  constexpr double kClose_mm = 1;
  const double above_mm =
      stand.nozzle_mm - TrueBedHeight_mm(built_, stand.raised_mm, stand.head_mm);
  if (std::abs(above_mm) > kClose_mm) return above_mm < 0;
  const auto trigger = TriggerAt(stand, built_.machine.probe.speeds_mm_s.back());
  return trigger &&
         stand.nozzle_mm <= trigger->height_mm + trigger->scatter_mm * chance_;
}

// At its trigger the nozzle is pushed in.
double TripleZTwinPlant::NozzleOverBed_mm(const Motors& steps) const {
  const Stand stand = StandAt(steps);
  const Row row = TouchRow(built_.machine, stand.raised_mm, stand.head_mm);
  const At at = AtOf(row, built_.machine, built_.machine.settings);
  const auto errors = ErrorsAt<double>(built_.machine, at, built_.effects);
  return stand.nozzle_mm - TrueBedHeight_mm(built_, stand.raised_mm, stand.head_mm) -
         Pretravel_mm(errors, at.n) - errors.more_pretravel_mm;
}

bool TripleZTwinPlant::Acts(const PinSensor& sensor, const Motors& steps) {
  const Stand stand = StandAt(steps);
  if (sensor.kind == PinSensor::Kind::kProbe) return ProbeActs(stand);
  if (sensor.motor >= 2) return stand.screws_mm[sensor.motor - 2] <= 0;
  return BeforeHome_mm(sensor.motor == 0 ? Axis::kX : Axis::kY, stand) <= 0;
}

void TripleZTwinPlant::Arm(const PinSensor& sensor) {
  if (sensor.kind == PinSensor::Kind::kProbe) chance_ = scatter_.Normal();
}

// On the way to the probe's trigger the head stands and all screws go alike.
Outcome TripleZTwinPlant::RunToProbe(const Segment& segment, bool is_release) {
  const Profile& profile = segment.profile;
  const Stand from = StandAt(segment.from_steps), to = StandAt(segment.to_steps);
  const auto trigger = TriggerAt(from, profile.feed_top_mm_s);
  if (!trigger) return {.time_s = profile.Duration_s()};
  const double touched_mm =
      trigger->height_mm + trigger->scatter_mm * scatter_.Normal();
  const bool goes_up = from.nozzle_mm <= to.nozzle_mm;
  if (goes_up != is_release) return {.time_s = profile.Duration_s()};
  const double share = (from.nozzle_mm - touched_mm) / (from.nozzle_mm - to.nozzle_mm);
  if (share > 1) return {.time_s = profile.Duration_s()};
  return {.stopped = true,
          .time_s = profile.Time_s(std::max(share, 0.0) * profile.length_mm)};
}

Outcome TripleZTwinPlant::RunToSwitch(const Segment& segment, Axis axis) const {
  const Profile& profile = segment.profile;
  const Stand from = StandAt(segment.from_steps), to = StandAt(segment.to_steps);
  // The part of the way on which something that goes from `before` to `after` is 0.
  const auto share_of = [](double before, double after) {
    if (before <= 0) return 0.0;
    return after > 0 ? 2.0 : before / (before - after);
  };
  if (axis != Axis::kZ) {
    const double share = share_of(BeforeHome_mm(axis, from), BeforeHome_mm(axis, to));
    if (share > 1) return {.time_s = profile.Duration_s()};
    return {.stopped = true, .time_s = profile.Time_s(share * profile.length_mm)};
  }
  // Each screw stops at its own.
  Motors stand_steps = segment.to_steps;
  double last = 0;
  for (int i = 0; i < kNumScrews; ++i) {
    const double share = share_of(from.screws_mm[i], to.screws_mm[i]);
    const double from_steps = segment.from_steps[2 + i];
    stand_steps[2 + i] =
        from_steps + std::min(share, 1.0) * (segment.to_steps[2 + i] - from_steps);
    last = std::max(last, share);
  }
  if (last > 1) return {.time_s = profile.Duration_s()};
  return {.stopped = true,
          .time_s = profile.Time_s(last * profile.length_mm),
          .stand_steps = stand_steps};
}

Outcome TripleZTwinPlant::Run(const Segment& segment, const Watch& watch) {
  Outcome outcome{.time_s = segment.profile.Duration_s()};
  is_triggered_ = false;
  const bool is_release = watch.kind == Watch::Kind::kProbeReleased;
  if (is_release || watch.kind == Watch::Kind::kProbeTriggered) {
    outcome = RunToProbe(segment, is_release);
    is_triggered_ = outcome.stopped && !is_release;
  } else if (watch.kind == Watch::Kind::kSwitchClosed) {
    outcome = RunToSwitch(segment, watch.axis);
  }
  steps_ = outcome.stand_steps.value_or(segment.Steps(outcome.time_s));
  return outcome;
}

FirmwareOptions FirmwareOnScrews(const Pivots<double>& believed_mm) {
  constexpr double kRecovery_s = 0.2;  // M558 R.
  return {.leadscrews = Leadscrews{.at_mm = believed_mm},
          .probe_recovery_s = kRecovery_s};
}

double TrueBedHeight_mm(const BuiltTripleZ& built,
                        const Vec3<double>& raised_mm,
                        const Eigen::Vector2d& at_mm) {
  const Row row = TouchRow(built.machine, raised_mm, at_mm);
  return ClosedFormTouch_mm(built.machine,
                            built.effects,
                            row,
                            AtOf(row, built.machine, built.machine.settings));
}

}  // namespace caltwin

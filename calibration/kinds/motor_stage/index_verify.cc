#include <cmath>

#include <fmt/format.h>

#include "calibration/kinds/motor_stage/doing.h"

namespace caltwin {
namespace {

/// One turn looked at.
struct Turn {
  int edges = 0;
  double off_pulses = 0;  ///< Of the counter at the index, against whole turns.
};

/// From where, against which index.
struct Start {
  double reference_pulses = 0;  ///< Counter at an index, found slowly.
  double from_unit = 0;         ///< The start, from that index.
  double per_rev = 0;
  double lead_unit = 0;
  int attempts = 0;
};

double OffWholeTurns(double pulses, double per_rev) {
  return pulses - per_rev * std::round(pulses / per_rev);
}

std::optional<Turn> GoOneTurn(const Start& start,
                              double speed_unit_s,
                              MotorDoing* doing) {
  MotorAxes& axes = doing->axes();
  const std::size_t axis = doing->options().axes.front();
  const double pulses_per_unit = start.per_rev / start.lead_unit;
  const double from_unit = start.reference_pulses / pulses_per_unit + start.from_unit;
  const bool is_done = doing->Did(axes.MoveTo(axis, from_unit, speed_unit_s)) &&
                       doing->Did(axes.ClearDrive(axis)) &&
                       doing->Did(axes.MoveBy(axis, start.lead_unit, speed_unit_s));
  if (!is_done) return std::nullopt;
  const auto says = doing->Got(axes.Drive(axis));
  if (!says) return std::nullopt;
  Turn turn{.edges = says->index_edges};
  if (says->index) {
    turn.off_pulses = OffWholeTurns(
        static_cast<double>(*says->index) - start.reference_pulses, start.per_rev);
  }
  return turn;
}

MotorCondition Mismatch(const Turn& turn, std::size_t axis, double threshold_pulses) {
  const std::string name = MotorAxisName(axis);
  MotorCondition condition{
      .kind = MotorCondition::Kind::kMismatch, .axis = axis, .can_move = true};
  condition.words =
      turn.edges != 1
          ? fmt::format(
                "{} index pulses in one turn of {}, expected 1", turn.edges, name)
          : fmt::format(
                "position mismatch, the counter of {} is {:+.0f} pulses off at "
                "the index (threshold {:g})",
                name,
                turn.off_pulses,
                threshold_pulses);
  return condition;
}

// One turn at that speed, against an index found slowly: a counter that was wrong is
// wrong until it is at an index again. The text takes zero for one.
std::optional<Turn> Verify(double speed_unit_s,
                           double slow_unit_s,
                           Start* start,
                           MotorDoing* doing) {
  const MotorOptions& o = doing->options();
  const std::size_t axis = o.axes.front();
  if (!o.is_as_published && !MakeRoom(axis, doing)) return std::nullopt;
  if (!o.is_as_published || start->attempts > 0) {
    const auto reference = FindIndex(axis, start->lead_unit, slow_unit_s, doing);
    if (!reference) return std::nullopt;
    start->reference_pulses = static_cast<double>(*reference);
  }
  const auto turn = GoOneTurn(*start, speed_unit_s, doing);
  if (!turn) return std::nullopt;
  ++start->attempts;
  doing->done().found.index_edges = turn->edges;
  doing->Step({.quantity = "index_pulses." + MotorAxisName(axis),
               .unit = "pulses",
               .after = static_cast<double>(turn->edges),
               .verdict = Verdict::kMeasured,
               .message = fmt::format("at {:g} {}/s, counter {:+.0f} pulses off at the "
                                      "index",
                                      speed_unit_s,
                                      doing->axes().drawing(axis).unit(),
                                      turn->off_pulses)});
  const bool is_good =
      turn->edges == 1 && std::abs(turn->off_pulses) <= o.threshold_pulses;
  if (is_good) return turn;
  doing->Meet(Mismatch(*turn, axis, o.threshold_pulses));
  return std::nullopt;
}

// A zero that is no index: homed as published, or counts were lost since.
void TellOfZero(const Start& start, MotorDoing* doing) {
  const MotorOptions& o = doing->options();
  const double off_pulses = OffWholeTurns(start.reference_pulses, start.per_rev);
  if (o.is_as_published || std::abs(off_pulses) <= o.threshold_pulses) return;
  doing->Warn(
      fmt::format("zero of {} stands {:+.0f} pulses from an index: it was homed as "
                  "published, or its "
                  "counter has lost as many since: home it again (corrected)",
                  MotorAxisName(o.axes.front()),
                  -off_pulses));
}

// It counts right only so slowly: kept so, and homed again.
void KeepSlow(double speed_unit_s, MotorDoing* doing) {
  MotorAxes& axes = doing->axes();
  const std::size_t axis = doing->options().axes.front();
  doing->Warn(
      fmt::format("{} counts right only up to {:g} {}/s (M203, stored): look at "
                  "its encoder's wires; homed again",
                  MotorAxisName(axis),
                  speed_unit_s,
                  axes.drawing(axis).unit()));
  if (!doing->Did(axes.SetField(203, axis, speed_unit_s)) || !doing->Store(axis)) {
    return;
  }
  doing->Absorb(RunServoHome(&axes, {.axes = {axis}, .slow = doing->options().slow}));
}

}  // namespace

MotorResult RunIndexVerify(MotorAxes* axes, const MotorOptions& options) {
  MotorDoing doing("index_verify", options, axes);
  const std::size_t axis = options.axes.front();
  const auto pulses = doing.Got(axes->Field(92, axis));
  const auto per_rev = doing.Got(axes->Field(812, axis));
  const auto top_unit_s = doing.TopSpeed_unit_s(axis);
  if (!pulses || !per_rev || !top_unit_s || !doing.IsHomed(axis)) return doing.Take();
  if (!MayHomeAtScale(axis, *pulses, *per_rev, &doing)) return doing.Take();
  Start start{.per_rev = *per_rev, .lead_unit = *per_rev / *pulses};
  if (!options.is_as_published) {
    start.from_unit = start.lead_unit / 2;
  }
  double speed_unit_s = 0;
  const auto turn =
      doing.TrySlower(options.medium * *top_unit_s, [&](double attempt_unit_s) {
        speed_unit_s = attempt_unit_s;
        auto verified =
            Verify(attempt_unit_s, options.slow * *top_unit_s, &start, &doing);
        if (start.attempts == 1) TellOfZero(start, &doing);
        return verified;
      });
  if (turn && start.attempts > 1) KeepSlow(speed_unit_s, &doing);
  return doing.Take();
}

}  // namespace caltwin

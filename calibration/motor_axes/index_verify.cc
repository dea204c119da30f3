#include <cmath>

#include "calibration/motor_axes/doing.h"
#include "sim/base/mutant.h"

namespace caltwin {
namespace {

/// One turn looked at.
struct Turn {
  int edges = 0;
  double off_pulses = 0;  ///< Of the counter at the index, against whole turns.
};

/// From where, how fast, against which index.
struct Start {
  double reference_pulses = 0;  ///< Counter at an index, found slowly.
  double from_unit = 0;         ///< The start, from that index.
  double per_rev = 0;
  double lead_unit = 0;
  double speed_unit_s = 0;
};

std::optional<Turn> GoOneTurn(const Start& start, MotorDoing* doing) {
  MotorAxes& axes = doing->axes();
  const std::size_t axis = doing->options().axes.front();
  const double pulses_per_unit = start.per_rev / start.lead_unit;
  const double from_unit = start.reference_pulses / pulses_per_unit + start.from_unit;
  const bool is_done =
      doing->Did(axes.MoveTo(axis, from_unit, start.speed_unit_s)) &&
      doing->Did(axes.ClearDrive(axis)) &&
      doing->Did(axes.MoveBy(axis, start.lead_unit, start.speed_unit_s));
  if (!is_done) return std::nullopt;
  const auto says = doing->Got(axes.Drive(axis));
  if (!says) return std::nullopt;
  Turn turn{.edges = says->index_edges};
  if (says->index) {
    const double gone = static_cast<double>(*says->index) - start.reference_pulses;
    turn.off_pulses = gone - start.per_rev * std::round(gone / start.per_rev);
  }
  return turn;
}

// A counter that was wrong is wrong until it is at an index again.
bool FindReference(Start* start, MotorDoing* doing) {
  MotorAxes& axes = doing->axes();
  const std::size_t axis = doing->options().axes.front();
  const double slow_unit_s =
      doing->options().slow * axes.drawing(axis).max_velocity_unit_s;
  const bool is_done =
      doing->Did(axes.ClearDrive(axis)) &&
      doing->Did(axes.SeekIndex(axis, 1.2 * start->lead_unit, slow_unit_s)) &&
      doing->Did(axes.WaitComplete());
  if (!is_done) return false;
  const auto says = doing->Got(axes.Drive(axis));
  if (!says || !says->index) return false;
  start->reference_pulses = static_cast<double>(*says->index);
  return true;
}

std::string WordsOf(const Turn& turn, std::size_t axis, double threshold_pulses) {
  const std::string name = MotorAxisName(axis);
  if (turn.edges != 1) {
    return fmt::format("{}: {} index pulses in one turn, expected 1", name, turn.edges);
  }
  return fmt::format(
      "{}: position mismatch, the counter is {:+.0f} pulses off at the "
      "index (threshold {:g})",
      name,
      turn.off_pulses,
      threshold_pulses);
}

}  // namespace

MotorResult RunIndexVerify(MotorAxes* axes, const MotorOptions& options) {
  MotorDoing doing("index_verify", options, axes);
  const std::size_t axis = options.axes.front();
  const MotorAxisDrawing& d = axes->drawing(axis);
  const auto pulses = doing.Got(axes->Field(92, axis));
  const auto per_rev = doing.Got(axes->Field(812, axis));
  if (!pulses || !per_rev) return doing.Take();
  Start start{.per_rev = *per_rev,
              .lead_unit = *per_rev / *pulses,
              .speed_unit_s = options.medium * d.max_velocity_unit_s};
  if (!Mutant("index_verify_starts_on_index", options.is_as_published, true)) {
    start.from_unit = start.lead_unit / 2;
  }
  std::string words;
  for (int attempt = 0; attempt <= options.retries; ++attempt) {
    const double speed_unit_s = start.speed_unit_s;
    if (attempt > 0 && !FindReference(&start, &doing)) return doing.Take();
    const auto turn = GoOneTurn(start, &doing);
    if (!turn) return doing.Take();
    doing.done().found.index_edges = turn->edges;
    doing.Step("index_pulses." + MotorAxisName(axis),
               1,
               turn->edges,
               Verdict::kMeasured,
               fmt::format("at {:g} {}/s, counter {:+.0f} pulses off at the index",
                           speed_unit_s,
                           d.unit(),
                           turn->off_pulses));
    const bool is_good =
        turn->edges == 1 && std::abs(turn->off_pulses) <= options.threshold_pulses;
    if (is_good && attempt == 0) return doing.Take();
    if (is_good) {
      doing.Warn(
          fmt::format("{} counts right only up to {:g} {}/s: home it again, and "
                      "look at its encoder's wires",
                      MotorAxisName(axis),
                      speed_unit_s,
                      d.unit()));
      doing.Did(axes->SetField(203, axis, speed_unit_s));
      return doing.Take();
    }
    words = WordsOf(*turn, axis, options.threshold_pulses);
    doing.Log(axis, words);
    if (attempt < options.retries) ++doing.done().found.retries;
    start.speed_unit_s /= 2;
  }
  doing.Alert(axis, words);
  doing.SafeSlow(axis);
  return doing.Take();
}

}  // namespace caltwin

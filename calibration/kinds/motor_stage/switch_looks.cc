#include "calibration/kinds/motor_stage/switch_looks.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kClearSigmas = 8;  // From one closing to the next: sqrt(2) of it.
constexpr int kSwitchLooksMostSteps = 4;  // So often back until the switch is open.

// chi-squared that k degrees of freedom exceed in one of 10 000 (Wilson and Hilferty,
// to 5 % from two degrees on).
double ChiSquaredLimit(double k) {
  constexpr double kSigmas = 3.719;
  const double part = 2 / (9 * k);
  return k * std::pow(1 - part + kSigmas * std::sqrt(part), 3);
}

double SumOfSquares(const SwitchLooks& looks) {
  const double mean = looks.mean_pulses();
  double sum = 0;
  for (const double at : looks.at_pulses) sum += (at - mean) * (at - mean);
  return sum;
}

// Back by so much, and again until the switch is open.
bool BackUntilOpen(const SwitchSeek& seek, double back_unit, MotorDoing* doing) {
  MotorAxes& axes = doing->axes();
  for (int i = 0; i < kSwitchLooksMostSteps; ++i) {
    const bool is_back = doing->Did(
        axes.MoveBy(seek.axis, -seek.sense * back_unit, 10 * seek.fine_unit_s));
    if (!is_back) return false;
    const auto pressed = doing->Got(axes.IsPressed(seek.axis, seek.sense < 0));
    if (!pressed) return false;
    if (!*pressed) return true;
  }
  doing->Meet({.kind = MotorCondition::Kind::kBacklash,
               .axis = seek.axis,
               .words = fmt::format("the {} switch of {} stays closed {:.3g} {} back "
                                    "from where it closed: excessive backlash, or it "
                                    "sticks",
                                    seek.sense < 0 ? "MIN" : "MAX",
                                    MotorAxisName(seek.axis),
                                    kSwitchLooksMostSteps * back_unit,
                                    axes.drawing(seek.axis).unit()),
               .can_move = true});
  return false;
}

}  // namespace

double SwitchLooks::mean_pulses() const {
  return std::accumulate(at_pulses.begin(), at_pulses.end(), 0.0) /
         static_cast<double>(at_pulses.size());
}

double SwitchLooks::mean_sd_unit() const {
  return sigma_unit / std::sqrt(static_cast<double>(at_pulses.size()));
}

std::vector<Contribution> SwitchLooks::Budget() const {
  const auto n = static_cast<double>(at_pulses.size());
  if (is_seen) {
    return {{.input = "switch, as seen", .u = mean_sd_unit(), .dof = n - 1}};
  }
  std::vector<Contribution> budget = drawn;
  for (Contribution& input : budget) input.u /= std::sqrt(n);
  return budget;
}

bool LookAtSwitch(const SwitchSeek& seek,
                  double pulses_per_unit,
                  SwitchLooks* looks,
                  MotorDoing* doing) {
  MotorAxes& axes = doing->axes();
  const MotorAxisDrawing& d = axes.drawing(seek.axis);
  const double came_unit_s =
      looks->at_pulses.empty() ? seek.came_unit_s : seek.fine_unit_s;
  const auto came_late_unit = SeenLate(seek.axis, came_unit_s, doing);
  const auto late_unit = SeenLate(seek.axis, seek.fine_unit_s, doing);
  const auto acceleration_unit_s2 = doing->Got(axes.Field(201, seek.axis));
  if (!came_late_unit || !late_unit || !acceleration_unit_s2) return false;
  // It may stand farther beyond by half the expander's period.
  const double beyond_unit =
      *came_late_unit + came_unit_s * axes.bench().drawing.poll_s / 2;
  // And room to come up to the speed again before the switch may close.
  const double run_up_unit =
      seek.fine_unit_s * seek.fine_unit_s / (2 * *acceleration_unit_s2);
  const double back_unit =
      beyond_unit + d.switch_hysteresis_unit + looks->clear_unit + run_up_unit;
  const double to_unit = kSwitchLooksMostSteps * back_unit + 5 * looks->clear_unit;
  const bool is_there =
      BackUntilOpen(seek, back_unit, doing) &&
      doing->Did(axes.SeekSwitch(seek.axis, seek.sense * to_unit, seek.fine_unit_s)) &&
      doing->Did(axes.WaitComplete());
  const auto count = is_there ? doing->Got(axes.Count(seek.axis)) : std::nullopt;
  if (!count) return false;
  looks->at_pulses.push_back(static_cast<double>(*count) -
                             seek.sense * *late_unit * pulses_per_unit);
  return true;
}

namespace {

bool LookOften(const SwitchSeek& seek,
               int times,
               double pulses_per_unit,
               SwitchLooks* looks,
               MotorDoing* doing) {
  looks->at_pulses.clear();
  for (int i = 0; i < times; ++i) {
    if (!LookAtSwitch(seek, pulses_per_unit, looks, doing)) return false;
  }
  return true;
}

// Of one look, by the looks.
double SeenSigmaOf(const SwitchLooks& looks, double pulses_per_unit) {
  const auto n = static_cast<double>(looks.at_pulses.size());
  return std::sqrt(SumOfSquares(looks) / (n - 1)) / pulses_per_unit;
}

}  // namespace

std::optional<SwitchLooks> LookFinely(const SwitchSeek& seek,
                                      int times,
                                      double pulses_per_unit,
                                      MotorDoing* doing) {
  const MotorBench& bench = doing->axes().bench();
  const MotorAxisDrawing& d = doing->axes().drawing(seek.axis);
  SwitchLooks looks{.sigma_unit = SwitchSigma(bench, seek.axis, seek.fine_unit_s),
                    .drawn = SwitchBudget(bench, seek.axis, seek.fine_unit_s)};
  const double drawn_unit = looks.sigma_unit;
  looks.clear_unit = std::max(looks.clear_unit, kClearSigmas * drawn_unit);
  if (!LookOften(seek, times, pulses_per_unit, &looks, doing)) return std::nullopt;
  if (times < 2) return looks;
  const double seen = SeenSigmaOf(looks, pulses_per_unit) / drawn_unit;
  // Five looks seldom prove a switch that scatters twice as much: what they show counts
  // where it is more, with as many degrees of freedom as it has.
  looks.is_seen = seen > 1;
  if (looks.is_seen) looks.sigma_unit = seen * drawn_unit;
  const bool is_more = (times - 1) * seen * seen > ChiSquaredLimit(times - 1);
  looks.scatters = is_more;
  if (!looks.scatters) return looks;
  // Anew from as far as the looks may have seen too little of it: what four degrees of
  // freedom tell is three times too small in one of fifty.
  constexpr double kTold = 3;
  looks.clear_unit = std::max(
      looks.clear_unit, kTold * kClearSigmas * SeenSigmaOf(looks, pulses_per_unit));
  if (!LookOften(seek, times, pulses_per_unit, &looks, doing)) return std::nullopt;
  looks.is_seen = true;
  looks.sigma_unit = std::max(SeenSigmaOf(looks, pulses_per_unit), drawn_unit);
  doing->Warn(fmt::format(
      "the {} switch of {} scatters by {:.1f} {} over {} looks, {:.1f} as drawn "
      "(switch_scatter): is it loose or worn? What was seen counts",
      seek.sense < 0 ? "MIN" : "MAX",
      MotorAxisName(seek.axis),
      UmFromMm(looks.sigma_unit),
      d.fine_unit(),
      times,
      UmFromMm(drawn_unit)));
  return looks;
}

}  // namespace caltwin

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "calibration/estimate/expanded.h"
#include "calibration/kinds/motor_stage/doing.h"

namespace caltwin {
namespace {

constexpr double kGentle = 0.5;      // Of the friction: so a carriage does not coast.
constexpr double kHunts_pulses = 1;  // Of a servo at rest, farthest to nearest.
constexpr double kWorseBy = 4;       // Standard uncertainties that a check may be off.
constexpr double kIsThere = 2;       // Of them a gap must be to be one.

/// A gap with its standard uncertainty [mm, deg].
struct BacklashGap {
  double value_unit = 0;
  double sd_unit = 0;
  std::vector<Contribution> budget{};
  double left_unit = 0;  ///< What the commanded place still differs by.
};

// One approach to `at_unit` from `from_unit`: gauge less counter, and gauge.
struct Approach {
  double beyond_counter_unit = 0;
  double gauge_unit = 0;
};

std::optional<Approach> ReadApproach(double from_unit,
                                     double at_unit,
                                     double speed_unit_s,
                                     MotorDoing* doing) {
  MotorAxes& axes = doing->axes();
  const std::size_t axis = doing->options().axes.front();
  if (!doing->Did(axes.MoveTo(axis, from_unit, speed_unit_s)) ||
      !doing->Did(axes.MoveTo(axis, at_unit, speed_unit_s))) {
    return std::nullopt;
  }
  const auto count = doing->Got(axes.Count(axis));
  const auto pulses = doing->Got(axes.Field(92, axis));
  const auto gauge_unit =
      doing->Got(axes.bench().gauge->Read_mm("laser." + MotorAxisName(axis)));
  if (!count || !pulses || !gauge_unit) return std::nullopt;
  const double counter_unit = static_cast<double>(*count) / *pulses;
  return Approach{*gauge_unit - counter_unit, *gauge_unit};
}

// Moving in + the carriage lags the counter, moving in - it leads.
std::optional<BacklashGap> MeasureGap(double speed_unit_s, MotorDoing* doing) {
  const MotorOptions& o = doing->options();
  const double at_unit = 2 * o.distance_unit;
  BacklashGap gap;
  for (int i = 0; i < o.repeats; ++i) {
    const auto plus =
        ReadApproach(at_unit - o.distance_unit, at_unit, speed_unit_s, doing);
    const auto minus =
        ReadApproach(at_unit + o.distance_unit, at_unit, speed_unit_s, doing);
    if (!plus || !minus) return std::nullopt;
    gap.value_unit +=
        (minus->beyond_counter_unit - plus->beyond_counter_unit) / o.repeats;
    gap.left_unit += (minus->gauge_unit - plus->gauge_unit) / o.repeats;
  }
  const auto pulses = doing->Got(doing->axes().Field(92, o.axes.front()));
  if (!pulses) return std::nullopt;
  const double rounding_unit = 1 / *pulses / std::sqrt(12.0);
  const double readings_unit =
      std::hypot(doing->axes().bench().gauge_sigma_unit, rounding_unit) *
      std::sqrt(2.0 / o.repeats);
  // A servo hunts about its place: the carriage stays where it was pushed farthest, the
  // counter does not, so that a gap reads too small by anything from none to a pulse.
  // In the mean of all approaches alike, so repeats do not tell it. Where there is no
  // gap the carriage hunts with its motor.
  const double hunting_unit = kHunts_pulses / *pulses / std::sqrt(12.0);
  gap.sd_unit = std::hypot(readings_unit, hunting_unit);
  const bool is_there = gap.value_unit > kIsThere * gap.sd_unit;
  if (is_there) gap.value_unit += kHunts_pulses / 2 / *pulses;
  gap.budget = {{.input = "readings", .u = readings_unit},
                {.input = "a servo's hunting", .u = hunting_unit}};
  return gap;
}

// Slow enough at the end that rail friction stops the carriage with its motor.
bool Gently(MotorDoing* doing) {
  const std::size_t axis = doing->options().axes.front();
  const MotorAxisDrawing& d = doing->axes().drawing(axis);
  const auto usual = doing->Got(doing->axes().Field(201, axis));
  const double friction_unit_s2 = d.friction / d.load_inertia / d.si_per_unit();
  return usual &&
         doing->SetForNow(201, axis, std::min(*usual, kGentle * friction_unit_s2));
}

MotorResult AsPublished(MotorDoing doing) {
  const MotorOptions& o = doing.options();
  MotorAxes& axes = doing.axes();
  const std::size_t axis = o.axes.front();
  const auto top_unit_s = doing.TopSpeed_unit_s(axis);
  const auto pulses = doing.Got(axes.Field(92, axis));
  if (!pulses || !top_unit_s) return doing.Take();
  const double speed_unit_s = o.medium * *top_unit_s;
  std::vector<std::int64_t> read;
  for (const double by_unit :
       {o.distance_unit, -2 * o.distance_unit, o.distance_unit}) {
    if (!doing.Did(axes.MoveBy(axis, by_unit, speed_unit_s))) return doing.Take();
    const auto count = doing.Got(axes.Count(axis));
    if (!count) return doing.Take();
    read.push_back(*count);
  }
  const double backlash_unit =
      static_cast<double>(std::abs(read[2] - read[0])) / *pulses;
  const std::string name = "backlash." + MotorAxisName(axis);
  if (!doing.Did(axes.SetField(425, axis, backlash_unit)) ||
      !doing.Did(axes.Store(axis))) {
    return doing.Take();
  }
  doing.Step(
      {.quantity = name,
       .unit = axes.drawing(axis).unit(),
       .after = backlash_unit,
       .verdict = Verdict::kApplied,
       .message =
           "as published: not measured, abs(P2 - P1) of the motor's own counter"});
  doing.Say(
      fmt::format("as published: not measured. {0:g} {1} is the way that the "
                  "counter was told to go, for any gap; M425 holds it now",
                  backlash_unit,
                  axes.drawing(axis).unit()));
  doing.Found({.name = name,
               .unit = axes.drawing(axis).unit(),
               .value = backlash_unit,
               .identifiable = true});
  return doing.Take();
}

// Measured at that speed; beyond the tolerance it is to be measured again, slower.
std::optional<BacklashGap> WithinTolerance(double speed_unit_s, MotorDoing* doing) {
  const MotorOptions& o = doing->options();
  const std::size_t axis = o.axes.front();
  const MotorAxisDrawing& d = doing->axes().drawing(axis);
  auto gap = MeasureGap(speed_unit_s, doing);
  if (!gap || gap->value_unit <= o.tolerance_unit) return gap;
  doing->Meet({.kind = MotorCondition::Kind::kBacklash,
               .axis = axis,
               .words = fmt::format("backlash of {} is {:.4f} +- {:.4f} {}, beyond the "
                                    "mechanical tolerance of {:g}: not compensated",
                                    MotorAxisName(axis),
                                    gap->value_unit,
                                    gap->sd_unit,
                                    d.unit(),
                                    o.tolerance_unit),
               .can_move = true});
  auto& told = doing->done().result.estimates;
  std::erase_if(told,
                [&](const Estimate& e) { return e.name.starts_with("backlash."); });
  doing->Found("backlash." + MotorAxisName(axis),
               d.unit(),
               WithBudget(gap->value_unit, gap->budget));
  return std::nullopt;
}

// Compensates, looks whether both senses meet now, and keeps it or takes it back.
void ApplyGap(const BacklashGap& gap,
              double before_unit,
              double speed_unit_s,
              MotorDoing* doing) {
  MotorAxes& axes = doing->axes();
  const std::size_t axis = doing->options().axes.front();
  const std::string name = "backlash." + MotorAxisName(axis);
  const std::string unit = axes.drawing(axis).unit();
  if (!doing->Did(axes.SetField(425, axis, gap.value_unit))) return;
  const auto check = MeasureGap(speed_unit_s, doing);
  if (!check) return;
  const double sd_unit = std::hypot(gap.sd_unit, check->sd_unit);
  const std::string words = fmt::format(
      "compensated, the two senses differ by {:+.4f} {}", check->left_unit, unit);
  if (std::abs(check->left_unit) > kWorseBy * sd_unit) {
    doing->Warn(words + ": that is no gap alone, M425 is as it was");
    doing->Step({.quantity = name,
                 .unit = unit,
                 .before = before_unit,
                 .after = before_unit,
                 .verdict = Verdict::kRolledBack,
                 .message = "the check failed"});
    return;
  }
  doing->Say(words);
  doing->KeepAsItIs(425, axis);
  if (!doing->Store(axis)) return;
  doing->Step({.quantity = name,
               .unit = unit,
               .before = before_unit,
               .after = gap.value_unit,
               .verdict = Verdict::kApplied,
               .message = "opposite approaches, read by the gauge"});
  // The switch is met from one side: home stands half of what is known now too far.
  doing->Say(
      fmt::format("home_offset.{0} holds half of this gap: home {0} again, now "
                  "that M425 has it",
                  MotorAxisName(axis)));
}

// There is none: what was compensated before is not any more.
void ForgetGap(double before_unit, MotorDoing* doing) {
  const std::size_t axis = doing->options().axes.front();
  if (before_unit == 0) return;
  doing->KeepAsItIs(425, axis);
  if (!doing->Store(axis)) return;
  doing->Step({.quantity = "backlash." + MotorAxisName(axis),
               .unit = doing->axes().drawing(axis).unit(),
               .before = before_unit,
               .after = 0,
               .verdict = Verdict::kApplied,
               .message = "no gap is seen, none is compensated"});
}

// A carriage that coasts on beyond its motor reads as less than no gap.
bool Coasts(const BacklashGap& gap, MotorDoing* doing) {
  const std::size_t axis = doing->options().axes.front();
  const bool is_less = gap.value_unit < -kWorseBy * gap.sd_unit;
  if (!is_less) return false;
  doing->Confess(
      fmt::format("the gap of {} reads {:+.4f} +- {:.4f} {}, less than none: its "
                  "carriage coasts on when the motor stands, it has less friction or "
                  "more load than drawn",
                  MotorAxisName(axis),
                  gap.value_unit,
                  gap.sd_unit,
                  doing->axes().drawing(axis).unit()),
      "backlash." + MotorAxisName(axis));
  doing->Say("nothing was written");
  return true;
}

// What is not clearly a gap is not written; a gauge that cannot tell is said to be one.
void Judge(const BacklashGap& gap,
           double before_unit,
           double speed_unit_s,
           MotorDoing* doing) {
  const std::size_t axis = doing->options().axes.front();
  const MotorAxisDrawing& d = doing->axes().drawing(axis);
  const std::string name = "backlash." + MotorAxisName(axis);
  if (kIsThere * gap.sd_unit > doing->options().tolerance_unit) {
    doing->Confess(
        fmt::format("a gauge of {:g} {} does not tell a gap of the tolerance, "
                    "{:g}, from none",
                    doing->axes().bench().gauge_sigma_unit,
                    d.unit(),
                    doing->options().tolerance_unit),
        name);
    doing->Say("nothing was written");
    return;
  }
  if (Coasts(gap, doing)) return;
  doing->Found(name, d.unit(), WithBudget(gap.value_unit, gap.budget));
  if (gap.value_unit > kIsThere * gap.sd_unit) {
    ApplyGap(gap, before_unit, speed_unit_s, doing);
    return;
  }
  doing->Say(fmt::format("no gap of {} is seen: less than {:.4f} {}",
                         MotorAxisName(axis),
                         std::max(0.0, gap.value_unit) + kIsThere * gap.sd_unit,
                         d.unit()));
  ForgetGap(before_unit, doing);
}

}  // namespace

MotorResult RunMotorBacklash(MotorAxes* axes, const MotorOptions& options) {
  MotorDoing doing("motor_backlash", options, axes);
  const std::size_t axis = options.axes.front();
  if (!doing.IsHomed(axis)) return doing.Take();
  if (options.is_as_published) return AsPublished(std::move(doing));
  if (axes->bench().gauge == nullptr) {
    doing.Confess(
        "the motor's own counter does not see what the carriage does: the "
        "backlash wants a gauge on the carriage",
        "backlash." + MotorAxisName(axis));
    return doing.Take();
  }
  const auto top_unit_s = doing.TopSpeed_unit_s(axis);
  const auto before_unit = doing.Got(axes->Field(425, axis));
  // Measured as if nothing were compensated.
  const bool may_begin =
      top_unit_s && before_unit && Gently(&doing) && doing.SetForNow(425, axis, 0);
  if (!may_begin) return doing.Take();
  const double medium_unit_s = options.medium * *top_unit_s;
  const auto gap = doing.TrySlower(medium_unit_s, [&](double speed_unit_s) {
    return WithinTolerance(speed_unit_s, &doing);
  });
  if (gap) Judge(*gap, *before_unit, medium_unit_s, &doing);
  return doing.Take();
}

}  // namespace caltwin

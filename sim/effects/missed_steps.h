#pragma once

#include "sim/base/units.h"
#include "sim/effects/drive.h"
#include "sim/effects/effect.h"
#include "sim/effects/forms.h"

namespace caltwin {

/// The motor loses steps once; everything after it is off, until the next homing.
///
///   actual - commanded = jump,  from at_t until the next homing   [mm]
///
/// Positive: the axis ends further to +. A row is hit where t >= at_t and its homing
/// session began at or before at_t. A motor slips by whole electrical turns: jumps are
/// multiples of 4 full steps, which the form does not enforce.
struct MissedSteps {
  static constexpr std::array<std::string_view, 3> kAxes = {"x", "y", "z"};
  static constexpr std::array kParameters = {
      Parameter{.name = "jump_um",
                .unit = "um",
                .min = -1e5,
                .max = 1e5,
                .prior = Normal{.mean = 0, .sd = 100},
                .doc = "+: the axis ends further to +."},
      Parameter{.name = "at_t_s",
                .unit = "s",
                .min = 0,
                .max = 1e10,
                .prior = Uniform{.min = 0, .max = 36000},
                .doc = "Time in the session at which it happens.",
                .role = Role::kForm}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = values[1] = 0;
  }
  static Shown In(std::string_view axis) {
    return {.channel = std::string(axis), .covariates = {"t"}};
  }
  static Forms Grid(const Machine&, std::string_view, const Extent& extent) {
    return OfOne(JumpTimes_s(extent));
  }
  static constexpr Effect kDeclaration = {
      .name = "missed_steps",
      .about = "The motor lost steps once: all that follows is off until homing.",
      .bucket = Bucket::kTime,
      .stage = Stage::kDrive,
      .axes = kAxes,
      .parameters = kParameters,
      .formula = "actual - commanded = jump, for t >= at_t until the next homing",
      .source =
          "A stalled stepper falls back by whole electrical turns, 4 full steps: 80 um "
          "with a lead of 4 mm and 200 steps, 0.8 mm on a belt of 40 mm per turn; an "
          "encoder or coupling may slip by any amount.",
      .twin =
          "A setup that was pushed: the same from then on; a datum touched again and "
          "again shows it, and homing takes away lost steps but not a pushed block.",
      .words =
          {.plot = "Residual against time: two levels, the second ends at a homing.",
           .values = "Multiples of 4 full steps, 0.08 to 0.8 mm.",
           .cause =
               "Collision, acceleration too high, current too low, a hot driver, a "
               "slipping coupling.",
           .effect = "Layers shift, all later features are off by the same amount.",
           .action =
               "Lower the acceleration or raise the current, look for what jams; home "
               "and measure again what came after the jump."},
      .neutral = Neutral,
      .sight = Sight{.shown = In, .forms = Grid}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    const T& at_t_s = asked.p[1];
    const bool is_hit = at_t_s <= asked.at.t_s && at_t_s >= asked.at.homed_at_s;
    if (!is_hit) return;
    DriveError_mm(asked.axis, errors) += MmFromUm(asked.p[0]);
  }
};

}  // namespace caltwin

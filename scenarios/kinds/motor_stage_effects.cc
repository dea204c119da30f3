#include "scenarios/kinds/motor_stage_effects.h"

#include <algorithm>
#include <array>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/units.h"
#include "sim/effects/catalog.h"

namespace caltwin {
namespace {

/// One number of an effect, and its act on the axis it stands for; `value` in mm (deg),
/// s, kg, N.
struct MotorParameter {
  std::string_view effect;
  std::string_view name;
  /// Behind the name: "mm" (of a rotary axis deg), "mm_s", "um" (mdeg), "ms", "kg",
  /// "n", "".
  std::string_view unit;
  Bounds own;  ///< Where the catalogue has no such parameter.
  void (*act)(double value, std::size_t axis, BuiltMotorStage* built);
  bool servo_only = false;
};

constexpr std::size_t kNoAxis = kNumMotorAxes;
constexpr double kLeast_kg = 1e-6;  // Of a load.

void AddObstacle(double at_unit, std::size_t axis, BuiltMotorStage* built) {
  // Nobody can stand in it: it is on the side of the start where it lies.
  if (at_unit > built->faults[axis].start_unit) {
    built->motors[axis].high_obstacle_unit = at_unit;
  } else {
    built->motors[axis].low_obstacle_unit = at_unit;
  }
}

// `start` stands before `obstacle`, which needs it.
const std::array kParameters = {
    MotorParameter{"start",
                   "at",
                   "mm",
                   {-1e4, 1e4},
                   [](double v, std::size_t i, BuiltMotorStage* b) {
                     b->faults[i].start_unit = v;
                   }},
    MotorParameter{"backlash",
                   "gap",
                   "mm",
                   {},
                   [](double v, std::size_t i, BuiltMotorStage* b) {
                     b->motors[i].gap_unit = v;
                   }},
    MotorParameter{"switch_scatter",
                   "sd",
                   "um",
                   {0, 1000},
                   [](double v, std::size_t i, BuiltMotorStage* b) {
                     b->faults[i].switch_scatter_unit = v;
                   }},
    MotorParameter{"switch_missing",
                   "min",
                   "",
                   {0, 1},
                   [](double v, std::size_t i, BuiltMotorStage* b) {
                     b->faults[i].min_switch_missing = v != 0;
                   }},
    MotorParameter{"switch_missing",
                   "max",
                   "",
                   {0, 1},
                   [](double v, std::size_t i, BuiltMotorStage* b) {
                     b->faults[i].max_switch_missing = v != 0;
                   }},
    MotorParameter{"index_position",
                   "from_switch",
                   "mm",
                   {0, 1e4},
                   [](double v, std::size_t i, BuiltMotorStage* b) {
                     b->motors[i].drawing.index_from_switch_unit = v;
                   },
                   true},
    MotorParameter{"index_missing",
                   "above",
                   "mm_s",
                   {0, 1e5},
                   [](double v, std::size_t i, BuiltMotorStage* b) {
                     b->faults[i].index_lost_above_unit_s = v;
                   },
                   true},
    MotorParameter{"pulse_loss",
                   "fraction",
                   "",
                   {0, 0.5},
                   [](double v, std::size_t i, BuiltMotorStage* b) {
                     b->faults[i].pulses_lost = v;
                   },
                   true},
    MotorParameter{"pulse_loss",
                   "above",
                   "mm_s",
                   {0, 1e5},
                   [](double v, std::size_t i, BuiltMotorStage* b) {
                     b->faults[i].pulses_lost_above_unit_s = v;
                   },
                   true},
    MotorParameter{"obstacle", "at", "mm", {-1e4, 1e4}, AddObstacle},
    MotorParameter{"load",
                   "added",
                   "kg",
                   {-1e4, 1e4},
                   [](double v, std::size_t i, BuiltMotorStage* b) {
                     double& load = b->motors[i].drawing.load_inertia;
                     load = std::max(load + v, kLeast_kg);
                   }},
    MotorParameter{"rail_friction",
                   "added",
                   "n",
                   {0, 1e5},
                   [](double v, std::size_t i, BuiltMotorStage* b) {
                     b->motors[i].drawing.friction += v;
                   }},
    MotorParameter{"counter_edge",
                   "part",
                   "",
                   {0, 1},
                   [](double v, std::size_t i, BuiltMotorStage* b) {
                     b->faults[i].pulse_part = v;
                   },
                   true},
    MotorParameter{"start_delay",
                   "delay",
                   "ms",
                   {0, 50},
                   [](double v, std::size_t i, BuiltMotorStage* b) {
                     b->faults[i].start_delay_s = v;
                   },
                   true}};

// As the effect is bounded on every machine, but for places (between the axis' hard
// stops) and loads (something is left of it).
Bounds BoundsOf(const MotorParameter& parameter, const MotorAxisDrawing& d) {
  if (parameter.name == "at") {
    return {d.min_switch_unit - d.stop_unit, d.max_switch_unit + d.stop_unit};
  }
  if (parameter.effect == "load") return {kLeast_kg - d.load_inertia, 1e4};
  if (parameter.effect == "index_position") return {0, d.lead_unit};
  const std::string declared = fmt::format("{}_{}", parameter.name, parameter.unit);
  return DeclaredBounds(parameter.effect, declared).value_or(parameter.own);
}

std::string KeyOf(const MotorParameter& parameter, bool is_rotary) {
  if (parameter.unit.empty()) return std::string(parameter.name);
  std::string unit(parameter.unit);
  if (is_rotary && unit.starts_with("mm")) unit.replace(0, 2, "deg");
  if (is_rotary && unit == "um") unit = "mdeg";
  if (is_rotary && unit == "kg") unit = "kg_m2";
  if (is_rotary && unit == "n") unit = "n_m";
  return fmt::format("{}_{}", parameter.name, unit);
}

std::string Suggestion(const std::string& effect) {
  const std::string nearest = NearestWord(effect, MotorEffectNames());
  return (nearest.empty() ? "" : fmt::format("did you mean '{}'? ", nearest)) +
         "there are " + fmt::format("{}", fmt::join(MotorEffectNames(), ", ")) +
         ", each followed by a dot and an axis of x y z a u v";
}

void ReadEffect(const std::string& key,
                const YamlValue& value,
                const MotorStageDrawing& drawing,
                std::vector<MotorEffectSpec>* specs) {
  const std::size_t dot = key.find('.');
  const std::string effect = key.substr(0, dot);
  const std::size_t axis = dot == std::string::npos
                               ? kNoAxis
                               : MotorAxisNamed(key.substr(dot + 1)).value_or(kNoAxis);
  const bool is_known =
      std::ranges::find(kParameters, effect, &MotorParameter::effect) !=
      kParameters.end();
  if (!is_known || axis == kNoAxis) {
    value.Fail("is no effect of an axis of a motor stage", Suggestion(effect));
    return;
  }
  YamlMap map = value.Map();
  const bool is_rotary = drawing.axes[axis].is_rotary;
  std::size_t found = 0;
  for (const MotorParameter& parameter : kParameters) {
    if (parameter.effect != effect) continue;
    const auto number = map.Optional(KeyOf(parameter, is_rotary));
    if (!number) continue;
    ++found;
    if (parameter.servo_only && !drawing.axes[axis].is_servo) {
      value.Fail(
          fmt::format("is of servos; {} is an open-loop stepper", MotorAxisName(axis)));
    }
    const Distribution drawn =
        number->NumberOrDistribution(BoundsOf(parameter, drawing.axes[axis]));
    const auto* plain = std::get_if<double>(&drawn);
    if (effect == "switch_missing" && (!plain || (*plain != 0 && *plain != 1))) {
      number->Fail("is neither 0 nor 1", "1: the switch is dead");
    }
    specs->push_back({.effect = effect,
                      .parameter = std::string(parameter.name),
                      .axis = axis,
                      .value = drawn,
                      .unit = std::string(parameter.unit)});
  }
  map.NoMoreKeys();
  if (effect == "pulse_loss" && found > 0 && !map.Has("fraction")) {
    value.Fail("loses no pulse", "say how many: {fraction: 0.01, ...}");
  }
  if (found == 0 && map.faults()->empty()) {
    std::vector<std::string> keys;
    for (const MotorParameter& parameter : kParameters) {
      if (parameter.effect == effect) keys.push_back(KeyOf(parameter, is_rotary));
    }
    value.Fail("changes nothing",
               fmt::format("it has the numbers {}", fmt::join(keys, ", ")));
  }
}

}  // namespace

std::vector<std::string> MotorEffectNames() {
  std::vector<std::string> names;
  for (const MotorParameter& parameter : kParameters) {
    if (names.empty() || names.back() != parameter.effect) {
      names.emplace_back(parameter.effect);
    }
  }
  return names;
}

std::vector<MotorEffectSpec> ReadMotorEffects(YamlMap map,
                                              const MotorStageDrawing& drawing) {
  std::vector<MotorEffectSpec> specs;
  for (const auto& [key, value] : map.Entries()) {
    ReadEffect(key, value, drawing, &specs);
  }
  // An obstacle lies on one side of where the axis starts, whatever comes first.
  std::ranges::stable_partition(
      specs, [](const MotorEffectSpec& spec) { return spec.effect == "start"; });
  return specs;
}

void ApplyMotorEffect(const MotorEffectSpec& spec,
                      double value,
                      BuiltMotorStage* built) {
  for (const MotorParameter& parameter : kParameters) {
    if (parameter.effect != spec.effect || parameter.name != spec.parameter) continue;
    const double in_units = spec.unit == "um"   ? MmFromUm(value)
                            : spec.unit == "ms" ? SFromMs(value)
                                                : value;
    parameter.act(in_units, spec.axis, built);
  }
}

}  // namespace caltwin

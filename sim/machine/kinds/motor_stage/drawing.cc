#include "sim/machine/kinds/motor_stage/drawing.h"

#include <stdexcept>

#include <fmt/format.h>

#include "sim/base/require.h"
#include "sim/base/units.h"

namespace caltwin {

namespace {

/// One axis as it is read: keys end in the unit of its kind.
class AxisReader {
 public:
  AxisReader(YamlMap* map, bool is_rotary) : map_(map), is_rotary_(is_rotary) {}

  // `name` + "_mm" or "_deg", `more` behind it.
  void Length(const std::string& name,
              double* value,
              Bounds bounds,
              const std::string& more = "") {
    const std::string unit = is_rotary_ ? "_deg" : "_mm";
    *value = map_->NumberOr(name + unit + more, *value, bounds);
  }
  void Either(const std::string& linear,
              const std::string& rotary,
              double* value,
              Bounds bounds) {
    *value = map_->NumberOr(is_rotary_ ? rotary : linear, *value, bounds);
  }

 private:
  YamlMap* map_;
  bool is_rotary_;
};

constexpr Bounds kLength{-1e5, 1e5};
constexpr Bounds kInertia{1e-6, 1e5};
constexpr std::size_t kFirstStepper = 4;  // u, and v behind it.

void RequireOrder(const MotorAxisDrawing& axis, YamlMap* map) {
  const bool is_ordered = axis.min_switch_unit < axis.min_unit &&
                          axis.min_unit < axis.max_unit &&
                          axis.max_unit < axis.max_switch_unit;
  if (is_ordered) return;
  map->faults()->Add(map->place(),
                     fmt::format("{}: min_switch = {:g}, min = {:g}, max = {:g}, "
                                 "max_switch = {:g} do not rise",
                                 map->path(),
                                 axis.min_switch_unit,
                                 axis.min_unit,
                                 axis.max_unit,
                                 axis.max_switch_unit),
                     "the travel lies between the switches");
}

void ReadMotor(YamlMap* map, MotorAxisDrawing* axis) {
  AxisReader read(map, axis->is_rotary);
  read.Either("lead_mm", "deg_per_rev", &axis->lead_unit, {1e-3, 1e4});
  axis->pulses_per_rev =
      map->NumberOr("pulses_per_rev", axis->pulses_per_rev, {4, 1e8});
  axis->full_steps_per_rev =
      map->NumberOr("full_steps_per_rev", axis->full_steps_per_rev, {4, 1e4});
  read.Either(
      "motor_inertia_kg", "motor_inertia_kg_m2", &axis->motor_inertia, kInertia);
  read.Either("moving_mass_kg", "inertia_kg_m2", &axis->load_inertia, kInertia);
  read.Either("rail_friction_n", "friction_n_m", &axis->friction, {0, 1e5});
  read.Either("force_n_per_a", "torque_n_m_per_a", &axis->force_per_amp, {1e-4, 1e5});
  axis->current_limit_a =
      map->NumberOr("current_limit_a", axis->current_limit_a, {1e-3, 1e4});
}

MotorAxisDrawing ReadMotorAxis(YamlMap map, MotorAxisDrawing axis) {
  axis.is_servo =
      map.WordOr("motor", axis.is_servo ? "servo" : "stepper", {"servo", "stepper"}) ==
      "servo";
  AxisReader read(&map, axis.is_rotary);
  read.Length("min", &axis.min_unit, kLength);
  read.Length("max", &axis.max_unit, kLength);
  ReadMotor(&map, &axis);
  read.Length("max_feed", &axis.max_velocity_unit_s, {1e-3, 1e5}, "_s");
  read.Length("acceleration", &axis.acceleration_unit_s2, {1e-3, 1e7}, "_s2");
  read.Length("min_switch", &axis.min_switch_unit, kLength);
  read.Length("max_switch", &axis.max_switch_unit, kLength);
  read.Length("switch_hysteresis", &axis.switch_hysteresis_unit, {0, 10});
  read.Length("switch_scatter", &axis.switch_scatter_unit, {1e-6, 10});
  read.Length("stop", &axis.stop_unit, {0.01, 100});
  read.Length("index_from_switch", &axis.index_from_switch_unit, {0, 1e4});
  RequireOrder(axis, &map);
  map.NoMoreKeys();
  return axis;
}

// What an axis has of which the file says nothing.
MotorAxisDrawing Usual(std::size_t index) {
  MotorAxisDrawing axis;
  if (kMotorAxisLetters[index] == 'a') {
    axis = {.is_rotary = true,
            .min_unit = 0,
            .max_unit = 180,
            .lead_unit = 4,
            .max_velocity_unit_s = 100,
            .acceleration_unit_s2 = 1000,
            .motor_inertia = 0.4,
            .load_inertia = 0.2,
            .friction = 0.5,
            .force_per_amp = 40,
            .current_limit_a = 10,
            .min_switch_unit = -6,
            .max_switch_unit = 186,
            .index_from_switch_unit = 3.1};
  }
  if (index >= kFirstStepper) {
    axis = {.is_servo = false,
            .max_unit = 100,
            .lead_unit = 8,
            .pulses_per_rev = 3200,
            .max_velocity_unit_s = 60,
            .acceleration_unit_s2 = 400,
            .motor_inertia = 2,
            .load_inertia = 1.5,
            .friction = 5,
            .force_per_amp = 100,
            .current_limit_a = 2,
            .max_switch_unit = 108};
  }
  return axis;
}

}  // namespace

std::string MotorAxisName(std::size_t axis) {
  return std::string(1, kMotorAxisLetters.at(axis));
}

std::optional<std::size_t> MotorAxisNamed(std::string_view name) {
  if (name.size() != 1) return std::nullopt;
  const std::size_t at = kMotorAxisLetters.find(name);
  if (at == std::string_view::npos) return std::nullopt;
  return at;
}

double MotorAxisDrawing::si_per_unit() const {
  constexpr double kMm_m = 1e-3;
  return is_rotary ? RadFromDeg(1.0) : kMm_m;
}

MotorStageDrawing ReadMotorStageDrawing(YamlMap* map) {
  MotorStageDrawing stage;
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) stage.axes[i] = Usual(i);
  if (const auto expander = map->Optional("switch_expander")) {
    YamlMap keys = expander->Map();
    stage.poll_s = SFromMs(keys.NumberOr("poll_ms", 5, {0.25, 1000}));
    stage.transfer_s = SFromMs(keys.NumberOr("transfer_ms", 0.4, {0, 100}));
    keys.NoMoreKeys();
  }
  return stage;
}

void ReadMotorAxes(YamlMap* map, MotorStageDrawing* stage) {
  const auto axes = map->Optional("axes");
  if (!axes) return;
  YamlMap by_axis = axes->Map();
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    if (const auto axis = by_axis.Optional(MotorAxisName(i))) {
      stage->axes[i] = ReadMotorAxis(axis->Map(), stage->axes[i]);
    }
  }
  by_axis.NoMoreKeys();
}

const MotorStageDrawing& MotorStageOf(const Machine& machine) {
  const auto* const drawing = machine.Own<MotorStageDrawing>();
  if (drawing == nullptr) throw std::logic_error("this machine is a motor stage");
  return *drawing;
}

}  // namespace caltwin

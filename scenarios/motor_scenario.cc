#include "scenarios/motor_scenario.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scenarios/motor_effects.h"
#include "scenarios/named_step.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr std::array<std::string_view, 8> kProcedures = {"servo_home",
                                                         "index_verify",
                                                         "stepper_home",
                                                         "travel_limits",
                                                         "axis_sync",
                                                         "emergency_stop",
                                                         "motor_backlash",
                                                         "gcode"};
constexpr std::array<const char*, 11> kFigures = {"alerts",
                                                  "retries",
                                                  "warnings",
                                                  "safe_modes",
                                                  "index_edges",
                                                  "wrong_turn_probability",
                                                  "skew_ms",
                                                  "standstill_ms",
                                                  "stop_feasible",
                                                  "history_entries",
                                                  "machine_time_s"};
constexpr std::array<const char*, 4> kValues = {
    "backlash", "home_offset", "travel", "start_lead"};

std::vector<std::string> AxisWords() {
  std::vector<std::string> words;
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) words.push_back(MotorAxisName(i));
  return words;
}

YamlMap MapOf(const YamlValue& options) {
  if (!options.is_null()) return options.Map();
  return {YAML::Node(YAML::NodeType::Map),
          options.file(),
          options.path(),
          options.faults()};
}

// axis: x, or axes: [x, y].
void ReadStepAxes(const std::string& name,
                  const MotorStageDrawing& drawing,
                  YamlMap* map,
                  MotorOptions* o) {
  const bool is_stepper_step = name == "stepper_home";
  const bool takes_several = name == "axis_sync" || name == "emergency_stop";
  if (takes_several) {
    o->axes.clear();
    if (const auto axes = map->Required("axes")) {
      for (const YamlValue& each : axes->List()) {
        o->axes.push_back(*MotorAxisNamed(each.Word(AxisWords())));
      }
      if (o->axes.empty()) axes->Fail("is empty", "name axes: [x, y]");
    }
    if (o->axes.empty()) o->axes = {0};
    return;
  }
  const auto axis = map->Required("axis");
  if (!axis) return;
  o->axes = {*MotorAxisNamed(axis->Word(AxisWords()))};
  const bool is_servo = drawing.axes[o->axes.front()].is_servo;
  const bool needs_servo =
      name == "servo_home" || name == "index_verify" || name == "motor_backlash";
  if (needs_servo && !is_servo) {
    axis->Fail(fmt::format("= {} is an open-loop stepper: {} needs a servo",
                           MotorAxisName(o->axes.front()),
                           name));
  }
  if (is_stepper_step && is_servo) {
    axis->Fail(fmt::format("= {} is a servo: servo_home homes it",
                           MotorAxisName(o->axes.front())));
  }
}

void ReadSpeeds(YamlMap* map, MotorOptions* o) {
  constexpr Bounds kPart{1e-3, 1};
  o->slow = map->NumberOr("slow", o->slow, kPart, "a part of the highest speed");
  o->medium = map->NumberOr("medium", o->medium, kPart, "a part of the highest speed");
  o->second = map->NumberOr("second", o->second, kPart, "a part of the slow speed");
  o->retries = static_cast<int>(map->IntegerOr("retries", o->retries, 0, 10));
}

void ReadDistances(YamlMap* map, MotorOptions* o) {
  constexpr Bounds kDistance{1e-3, 1e3};
  if (const auto back = map->Optional("back_off_mm")) {
    o->back_off_unit = back->Number(kDistance);
  }
  o->final_back_off_unit =
      map->NumberOr("final_back_off_mm", o->final_back_off_unit, kDistance);
  o->safe_unit = map->NumberOr("safe_mm", o->safe_unit, kDistance);
  o->distance_unit = map->NumberOr("distance_mm", o->distance_unit, kDistance);
  o->margin_unit = map->NumberOr("margin_mm", o->margin_unit, {0, 1e3});
  o->tolerance_unit = map->NumberOr("tolerance_mm", o->tolerance_unit, kDistance);
}

MotorStep ReadMotorStep(const std::string& name,
                        const YamlValue& value,
                        const MotorStageDrawing& drawing) {
  MotorStep step{.name = name};
  YamlMap map = MapOf(value);
  if (name == "gcode") {
    if (const auto lines = map.Required("lines")) {
      for (const YamlValue& line : lines->List()) step.lines.push_back(line.Text());
    }
    map.NoMoreKeys();
    return step;
  }
  MotorOptions& o = step.options;
  o.is_as_published =
      map.WordOr("variant", "corrected", {"as_published", "corrected"}) ==
      "as_published";
  ReadStepAxes(name, drawing, &map, &o);
  ReadSpeeds(&map, &o);
  ReadDistances(&map, &o);
  o.repeats = static_cast<int>(map.IntegerOr("repeats", o.repeats, 1, 1000));
  o.touches = static_cast<int>(map.IntegerOr("touches", o.touches, 1, 100));
  o.fine_unit_s = map.NumberOr("fine_mm_s", o.fine_unit_s, {1e-3, 100});
  o.threshold_pulses = map.NumberOr("threshold_pulses", o.threshold_pulses, {0, 1e6});
  o.within_s =
      SFromMs(map.NumberOr("within_ms", o.within_s / SFromMs(1.0), {0.1, 1e4}));
  map.NoMoreKeys();
  return step;
}

void ReadSettings(YamlMap map, MotorScenario* scenario) {
  constexpr std::array<std::pair<const char*, int>, 3> kFields = {
      {{"steps_per_mm", 92}, {"home_offset_mm", 206}, {"pulses_per_rev", 812}}};
  for (const auto& [key, code] : kFields) {
    const auto value = map.Optional(key);
    if (!value) continue;
    YamlMap by_axis = value->Map();
    for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
      const auto number = by_axis.Optional(MotorAxisName(i));
      if (!number) continue;
      const Bounds bounds = code == 206 ? Bounds{-1e4, 1e4} : Bounds{1e-3, 1e7};
      scenario->settings.push_back({code, {i, number->Number(bounds)}});
    }
    by_axis.NoMoreKeys();
  }
  map.NoMoreKeys();
}

Within ReadWithin(const YamlValue& value) {
  YamlMap bounds = value.Map();
  Within within;
  if (const auto above = bounds.Optional("above")) within.above = above->Number();
  if (const auto below = bounds.Optional("below")) within.below = below->Number();
  if (!within.above && !within.below && bounds.faults()->empty()) {
    value.Fail("expects nothing", "write {above: ...} or {below: ...}");
  }
  bounds.NoMoreKeys();
  return within;
}

DeltaExpectedValue ReadExpectedValue(const std::string& name, const YamlValue& value) {
  DeltaExpectedValue expected{.name = name};
  YamlMap keys = value.Map();
  if (const auto within = keys.Optional("truth_within")) {
    expected.truth_within = within->Number(kNotNegative);
  }
  if (const auto flag = keys.Optional("identifiable")) {
    expected.identifiable = flag->Flag();
  }
  if (!expected.truth_within && !expected.identifiable && keys.faults()->empty()) {
    value.Fail("expects nothing", "write {truth_within: ...} or {identifiable: ...}");
  }
  keys.NoMoreKeys();
  return expected;
}

void ReadExpectation(YamlMap map, MotorScenario* scenario) {
  scenario->outcome = map.WordOr(
      "outcome",
      "recovers",
      {"recovers", "misses", "refused", "confounded", "no_trigger", "alarm"});
  std::vector<std::string> figures(kFigures.begin(), kFigures.end());
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    figures.push_back("home." + MotorAxisName(i));
    figures.push_back("compensated." + MotorAxisName(i));
  }
  for (const std::string& figure : figures) {
    if (const auto value = map.Optional(figure)) {
      scenario->figures.emplace_back(figure, ReadWithin(*value));
    }
  }
  if (const auto messages = map.Optional("messages")) {
    for (const YamlValue& text : messages->List()) {
      scenario->messages.push_back(text.Text());
    }
  }
  for (const char* value_name : kValues) {
    for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
      const std::string name = fmt::format("{}.{}", value_name, MotorAxisName(i));
      if (const auto value = map.Optional(name)) {
        scenario->values.push_back(ReadExpectedValue(name, *value));
      }
    }
  }
  map.NoMoreKeys();
}

}  // namespace

MotorScenario ReadMotorScenario(YamlMap* map, const MotorStageDrawing& drawing) {
  MotorScenario scenario{.drawing = drawing};
  if (const auto effects = map->Optional("effects")) {
    scenario.effects = ReadMotorEffects(effects->Map(), drawing);
  }
  if (const auto settings = map->Optional("settings")) {
    ReadSettings(settings->Map(), &scenario);
  }
  if (const auto instruments = map->Optional("instruments")) {
    YamlMap by_name = instruments->Map();
    if (const auto laser = by_name.Optional("laser")) {
      YamlMap keys = laser->Map();
      scenario.laser_sigma_unit =
          MmFromUm(keys.NumberOr("sigma_um", 0.5, {0.001, 1000}));
      keys.NoMoreKeys();
    }
    by_name.NoMoreKeys();
  }
  if (const auto calibrate = map->Required("calibrate")) {
    for (const NamedStep& step :
         ReadNamedSteps(*calibrate, kProcedures, "procedure of a motor stage")) {
      scenario.calibrate.push_back(ReadMotorStep(step.name, step.options, drawing));
    }
  }
  if (const auto expect = map->Optional("expect")) {
    ReadExpectation(expect->Map(), &scenario);
  }
  return scenario;
}

BuiltMotorStage DrawMotorStage(const MotorScenario& scenario,
                               std::uint64_t seed,
                               std::uint64_t sample) {
  BuiltMotorStage built{.drawing = scenario.drawing};
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    const MotorAxisDrawing& d = scenario.drawing.axes[i];
    built.motors[i].drawing = d;
    built.faults[i].start_unit = (d.min_unit + d.max_unit) / 4;
  }
  for (const MotorEffectSpec& spec : scenario.effects) {
    Rng rng(
        seed,
        sample,
        fmt::format("{}.{}.{}", spec.effect, MotorAxisName(spec.axis), spec.parameter));
    ApplyMotorEffect(spec, Draw(spec.value, &rng), &built);
  }
  return built;
}

}  // namespace caltwin

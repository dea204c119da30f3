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

constexpr std::array<std::string_view, 9> kProcedures = {"servo_home",
                                                         "index_verify",
                                                         "stepper_home",
                                                         "travel_limits",
                                                         "axis_sync",
                                                         "emergency_stop",
                                                         "motor_backlash",
                                                         "gcode",
                                                         "power_cut"};
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
        const std::size_t axis = *MotorAxisNamed(each.Word(AxisWords()));
        const bool is_twice = std::ranges::find(o->axes, axis) != o->axes.end();
        if (is_twice) each.Fail("is named twice");
        o->axes.push_back(axis);
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

// Which procedure heeds which option; another's is an unknown key, not ignored.
struct MotorOptionKeys {
  std::string_view procedure{};
  std::vector<std::string_view> keys{};
};

bool Heeds(std::string_view procedure, std::string_view key) {
  static const std::array<MotorOptionKeys, 7> kKeys = {{
      {"servo_home", {"slow", "back_off_mm"}},
      {"index_verify", {"slow", "medium", "threshold_pulses"}},
      {"stepper_home",
       {"slow",
        "second",
        "back_off_mm",
        "final_back_off_mm",
        "safe_mm",
        "touches",
        "fine_mm_s"}},
      {"travel_limits", {"slow", "margin_mm", "touches", "fine_mm_s"}},
      {"axis_sync", {"slow", "medium", "distance_mm", "repeats"}},
      {"emergency_stop",
       {"slow", "medium", "distance_mm", "within_ms", "threshold_pulses"}},
      {"motor_backlash", {"slow", "medium", "distance_mm", "repeats", "tolerance_mm"}},
  }};
  const auto entry = std::ranges::find(kKeys, procedure, &MotorOptionKeys::procedure);
  return std::ranges::find(entry->keys, key) != entry->keys.end();
}

void ReadNumbers(const std::string& name, YamlMap* map, MotorOptions* o) {
  constexpr Bounds kPart{1e-3, 1}, kDistance{1e-3, 1e3};
  const auto read = [&](const char* key, Bounds bounds, double* value) {
    if (Heeds(name, key)) *value = map->NumberOr(key, *value, bounds);
  };
  read("slow", kPart, &o->slow);
  read("medium", kPart, &o->medium);
  read("second", kPart, &o->second);
  read("final_back_off_mm", kDistance, &o->final_back_off_unit);
  read("safe_mm", kDistance, &o->safe_unit);
  read("distance_mm", kDistance, &o->distance_unit);
  read("tolerance_mm", kDistance, &o->tolerance_unit);
  read("margin_mm", {0, 1e3}, &o->margin_unit);
  read("fine_mm_s", {1e-3, 100}, &o->fine_unit_s);
  read("threshold_pulses", {0, 1e6}, &o->threshold_pulses);
  double within_ms = o->within_s / SFromMs(1.0);
  read("within_ms", {0.1, 1e4}, &within_ms);
  o->within_s = SFromMs(within_ms);
  if (Heeds(name, "back_off_mm")) {
    if (const auto back = map->Optional("back_off_mm")) {
      o->back_off_unit = back->Number(kDistance);
    }
  }
  const auto count = [&](const char* key, int most, int* value) {
    if (!Heeds(name, key)) return;
    *value = static_cast<int>(map->IntegerOr(key, *value, 1, most));
  };
  count("repeats", 1000, &o->repeats);
  count("touches", 100, &o->touches);
}

void ReadLines(YamlMap* map, bool must_be_there, MotorStep* step) {
  const auto lines = must_be_there ? map->Required("lines") : map->Optional("lines");
  if (!lines) return;
  for (const YamlValue& line : lines->List()) step->lines.push_back(line.Text());
}

MotorStep ReadMotorStep(const std::string& name,
                        const YamlValue& value,
                        const MotorStageDrawing& drawing) {
  MotorStep step{.name = name};
  YamlMap map = MapOf(value);
  if (name == "gcode" || name == "power_cut") {
    ReadLines(&map, name == "gcode", &step);
    if (name == "power_cut") {
      step.after_bytes =
          static_cast<std::uint64_t>(map.IntegerOr("after_bytes", 0, 0, 1'000'000));
    }
    map.NoMoreKeys();
    return step;
  }
  MotorOptions& o = step.options;
  // What was published of the stop is a wish, no procedure that could be followed.
  if (name != "emergency_stop") {
    o.is_as_published =
        map.WordOr("variant", "corrected", {"as_published", "corrected"}) ==
        "as_published";
  }
  ReadStepAxes(name, drawing, &map, &o);
  ReadNumbers(name, &map, &o);
  o.retries = static_cast<int>(map.IntegerOr("retries", o.retries, 0, 10));
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

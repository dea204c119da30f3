#include "scenarios/kinds/motor_stage_scenario.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scenarios/kinds/motor_stage_effects.h"
#include "scenarios/kinds/motor_stage_trial.h"
#include "scenarios/named_step.h"
#include "sim/base/units.h"

namespace caltwin {

bool TakesSeveralAxes(std::string_view procedure) {
  return procedure == "axis_sync" || procedure == "emergency_stop";
}

namespace {

constexpr std::array<std::string_view, 8> kProcedures = {"servo_home",
                                                         "index_verify",
                                                         "stepper_home",
                                                         "travel_limits",
                                                         "axis_sync",
                                                         "emergency_stop",
                                                         "motor_backlash",
                                                         "power_cut"};
constexpr std::array<const char*, 12> kFigures = {"alerts",
                                                  "retries",
                                                  "warnings",
                                                  "safe_modes",
                                                  "index_edges",
                                                  "wrong_turn_probability",
                                                  "skew_ms",
                                                  "standstill_ms",
                                                  "stop_feasible",
                                                  "stopped_within",
                                                  "positions_lost",
                                                  "history_entries"};
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
  if (TakesSeveralAxes(name)) {
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

// Which procedure heeds which option; another's is an unknown key, not ignored. Lengths
// and speeds are named here without the unit of the axis.
struct MotorOptionKeys {
  std::string_view procedure{};
  std::vector<std::string_view> keys{};
};

bool Heeds(std::string_view procedure, std::string_view key) {
  static const std::array<MotorOptionKeys, 7> kKeys = {{
      {"servo_home", {"slow", "back_off", "touches"}},
      {"index_verify", {"slow", "medium", "threshold_pulses"}},
      {"stepper_home",
       {"slow", "second", "back_off", "final_back_off", "safe", "touches", "fine"}},
      {"travel_limits", {"slow", "margin", "touches", "fine"}},
      {"axis_sync", {"slow", "medium", "distance", "repeats"}},
      {"emergency_stop",
       {"slow", "medium", "distance", "within_ms", "threshold_pulses", "tolerance"}},
      {"motor_backlash", {"slow", "medium", "distance", "repeats", "tolerance"}},
  }};
  const auto entry = std::ranges::find(kKeys, procedure, &MotorOptionKeys::procedure);
  return std::ranges::find(entry->keys, key) != entry->keys.end();
}

// Of several axes mm, unless all are rotary.
std::string UnitKey(const MotorOptions& o, const MotorStageDrawing& drawing) {
  const bool is_rotary = std::ranges::all_of(
      o.axes, [&](std::size_t axis) { return drawing.axes[axis].is_rotary; });
  return is_rotary ? "_deg" : "_mm";
}

// The shortest travel and the lowest highest speed of the axes.
struct Reach {
  double travel_unit = 1e9, speed_unit_s = 1e9;
};
Reach ReachOf(const MotorOptions& o, const MotorStageDrawing& drawing) {
  Reach reach;
  for (const std::size_t axis : o.axes) {
    const MotorAxisDrawing& d = drawing.axes[axis];
    reach.travel_unit = std::min(reach.travel_unit, d.max_unit - d.min_unit);
    reach.speed_unit_s = std::min(reach.speed_unit_s, d.max_velocity_unit_s);
  }
  return reach;
}

// In the unit of the axes, which stands in the key: safe_mm, safe_deg, fine_deg_s. None
// is longer than the axes' travel.
void ReadLengths(const std::string& name,
                 const std::string& unit,
                 const Reach& reach,
                 YamlMap* map,
                 MotorOptions* o) {
  const Bounds distance{1e-3, reach.travel_unit};
  // To and fro from the middle; three of them from zero; two within a move.
  const double of_travel = name == "axis_sync"        ? 2.0
                           : name == "motor_backlash" ? 3.0
                                                      : 2.5;
  const auto read = [&](const std::string& key, Bounds bounds, double* value) {
    if (Heeds(name, key)) *value = map->NumberOr(key + unit, *value, bounds);
  };
  read("final_back_off", distance, &o->final_back_off_unit);
  read("safe", distance, &o->safe_unit);
  read("distance", {1e-3, reach.travel_unit / of_travel}, &o->distance_unit);
  read("tolerance", distance, &o->tolerance_unit);
  read("margin", {0, reach.travel_unit / 2}, &o->margin_unit);
  if (Heeds(name, "fine")) {
    o->fine_unit_s =
        map->NumberOr("fine" + unit + "_s", o->fine_unit_s, {1e-3, reach.speed_unit_s});
  }
  if (!Heeds(name, "back_off")) return;
  if (const auto back = map->Optional("back_off" + unit)) {
    o->back_off_unit = back->Number(distance);
  }
}

void ReadNumbers(const std::string& name, YamlMap* map, MotorOptions* o) {
  constexpr Bounds kPart{1e-3, 1};
  const auto read = [&](const char* key, Bounds bounds, double* value) {
    if (Heeds(name, key)) *value = map->NumberOr(key, *value, bounds);
  };
  read("slow", kPart, &o->slow);
  read("medium", kPart, &o->medium);
  read("second", kPart, &o->second);
  read("threshold_pulses", {0, 1e6}, &o->threshold_pulses);
  double within_ms = o->within_s / SFromMs(1.0);
  read("within_ms", {0.1, 1e4}, &within_ms);
  o->within_s = SFromMs(within_ms);
  const auto count = [&](const char* key, int most, int* value) {
    if (!Heeds(name, key)) return;
    *value = static_cast<int>(map->IntegerOr(key, *value, 1, most));
  };
  count("repeats", 1000, &o->repeats);
  count("touches", 100, &o->touches);
}

MotorStep ReadMotorStep(const std::string& name,
                        const YamlValue& value,
                        const MotorStageDrawing& drawing) {
  MotorStep step{.name = name};
  YamlMap map = MapOf(value);
  if (name == "power_cut") {
    if (const auto lines = map.Optional("lines")) {
      for (const YamlValue& line : lines->List()) step.lines.push_back(line.Text());
    }
    step.after_bytes =
        static_cast<std::uint64_t>(map.IntegerOr("after_bytes", 0, 0, 1'000'000));
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
  ReadLengths(name, UnitKey(o, drawing), ReachOf(o, drawing), &map, &o);
  ReadNumbers(name, &map, &o);
  if (name == "motor_backlash" && o.distance_unit <= 2 * o.tolerance_unit) {
    value.Fail(fmt::format("goes {:g} from either side, not more than twice its "
                           "tolerance of {:g}",
                           o.distance_unit,
                           o.tolerance_unit),
               "a gap of the tolerance would not be crossed");
  }
  o.retries = static_cast<int>(map.IntegerOr("retries", o.retries, 0, 10));
  map.NoMoreKeys();
  return step;
}

/// A field of the record that a scenario sets before it begins.
struct MotorSettingKey {
  const char* key = "";
  int code = 0;                     ///< Its M-code.
  std::optional<bool> is_rotary{};  ///< Of these axes only.
};
constexpr std::array<MotorSettingKey, 5> kSettingKeys = {
    {{"steps_per_mm", 92, false},
     {"steps_per_deg", 92, true},
     {"home_offset_mm", 206, false},
     {"home_offset_deg", 206, true},
     {"pulses_per_rev", 812}}};

void ReadSettings(YamlMap map, MotorStageTruth* scenario) {
  for (const MotorSettingKey& setting : kSettingKeys) {
    const auto value = map.Optional(setting.key);
    if (!value) continue;
    YamlMap by_axis = value->Map();
    for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
      const bool is_rotary = scenario->drawing.axes[i].is_rotary;
      if (setting.is_rotary.value_or(is_rotary) != is_rotary) continue;
      // Of a stepper nothing counts turns against a stored offset.
      if (setting.code == 206 && !scenario->drawing.axes[i].is_servo) continue;
      const auto number = by_axis.Optional(MotorAxisName(i));
      if (!number) continue;
      const Bounds bounds = setting.code == 206 ? Bounds{-1e4, 1e4} : Bounds{1e-3, 1e7};
      scenario->settings.push_back({setting.code, {i, number->Number(bounds)}});
    }
    by_axis.NoMoreKeys();
  }
  map.NoMoreKeys();
}

void ReadMotorTruth(YamlMap* map, MotorStageTruth* scenario) {
  if (const auto effects = map->Optional("effects")) {
    scenario->effects = ReadMotorEffects(effects->Map(), scenario->drawing);
  }
  if (const auto settings = map->Optional("settings")) {
    ReadSettings(settings->Map(), scenario);
  }
}

}  // namespace

MotorStageTruth ReadMotorTruthFile(const std::filesystem::path& file,
                                   const MotorStageDrawing& drawing) {
  MotorStageTruth truth{.drawing = drawing};
  Faults faults;
  YamlMap map = ReadYamlFile(file, &faults);
  ReadMotorTruth(&map, &truth);
  map.NoMoreKeys();
  faults.ThrowIfAny();
  return truth;
}

std::vector<MotorStep> ReadMotorSteps(const YamlValue& list,
                                      const MotorStageDrawing& drawing) {
  std::vector<MotorStep> steps;
  for (const NamedStep& step :
       ReadNamedSteps(list, kProcedures, "procedure of a motor stage")) {
    steps.push_back(ReadMotorStep(step.name, step.options, drawing));
  }
  return steps;
}

void MotorStageScenario::ReadKeys(YamlMap* map, Scenario* /*scenario*/) {
  ReadMotorTruth(map, this);
  if (const auto instruments = map->Optional("instruments")) {
    YamlMap by_name = instruments->Map();
    if (const auto laser = by_name.Optional("laser")) {
      YamlMap keys = laser->Map();
      laser_sigma_unit = MmFromUm(keys.NumberOr("sigma_um", 0.5, {0.001, 1000}));
      keys.NoMoreKeys();
    }
    by_name.NoMoreKeys();
  }
}

std::vector<std::string> MotorStageScenario::StepNames() const {
  return {kProcedures.begin(), kProcedures.end()};
}

CalibrationStep MotorStageScenario::ReadStep(const std::string& name,
                                             const YamlValue& options,
                                             const std::string& /*usual_axis*/) const {
  const MotorStep step = ReadMotorStep(name, options, drawing);
  return {.name = name, .perform = [step](KindTrial* trial) {
            return dynamic_cast<MotorStageTrial&>(*trial).Take(step);
          }};
}

void MotorStageScenario::RefuseStep(const std::string& name,
                                    const YamlValue& options) const {
  RefuseNamedStep(name, options, kProcedures, "procedure of a motor stage");
}

Expectable MotorStageScenario::CanExpect() const {
  Expectable expectable{.figures = {kFigures.begin(), kFigures.end()}};
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    expectable.figures.push_back("home." + MotorAxisName(i));
    expectable.figures.push_back("compensated." + MotorAxisName(i));
    for (const char* value : kValues) {
      expectable.parameters.push_back(fmt::format("{}.{}", value, MotorAxisName(i)));
    }
  }
  return expectable;
}

std::vector<std::string> MotorStageScenario::EffectNames() const {
  return MotorEffectNames();
}

void MotorStageScenario::Vary(const std::string& effect,
                              const std::string& parameter,
                              const YamlValue& value,
                              Scenario* /*scenario*/) {
  for (const MotorEffectSpec& spec :
       ReadMotorEffects(value.Within(effect, parameter), drawing)) {
    std::erase_if(effects, [&](const MotorEffectSpec& had) {
      return had.effect == spec.effect && had.parameter == spec.parameter &&
             had.axis == spec.axis;
    });
    effects.push_back(spec);
  }
}

std::unique_ptr<KindTrial> MotorStageScenario::Begin(const Scenario& scenario,
                                                     const Chance& chance) const {
  return std::make_unique<MotorStageTrial>(*this, scenario.file, chance);
}

BuiltMotorStage DrawMotorStage(const MotorStageTruth& truth,
                               std::uint64_t seed,
                               std::uint64_t sample) {
  BuiltMotorStage built{.drawing = truth.drawing};
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    const MotorAxisDrawing& d = truth.drawing.axes[i];
    built.motors[i].drawing = d;
    built.faults[i].start_unit = (d.min_unit + d.max_unit) / 4;
  }
  for (const MotorEffectSpec& spec : truth.effects) {
    Rng rng(
        seed,
        sample,
        fmt::format("{}.{}.{}", spec.effect, MotorAxisName(spec.axis), spec.parameter));
    ApplyMotorEffect(spec, Draw(spec.value, &rng), &built);
  }
  return built;
}

}  // namespace caltwin

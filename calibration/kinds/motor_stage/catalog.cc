#include "calibration/kinds/motor_stage/catalog.h"

#include <algorithm>
#include <array>
#include <string>

#include <fmt/format.h>

#include "calibration/kinds/motor_stage/procedures.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr std::string_view kMotorStageKind = "motor_stage";

struct NamedProcedure {
  std::string_view name;
  MotorResult (*run)(MotorAxes* axes, const MotorOptions& options);
};
constexpr std::array kNamed = {NamedProcedure{"servo_home", RunServoHome},
                               NamedProcedure{"index_verify", RunIndexVerify},
                               NamedProcedure{"stepper_home", RunStepperHome},
                               NamedProcedure{"travel_limits", RunTravelLimits},
                               NamedProcedure{"axis_sync", RunAxisSync},
                               NamedProcedure{"emergency_stop", RunEmergencyStop},
                               NamedProcedure{"motor_backlash", RunMotorBacklash}};

constexpr bool TakesSeveralAxes(std::string_view procedure) {
  return procedure == "axis_sync" || procedure == "emergency_stop";
}

std::vector<std::string> AxisWords() {
  std::vector<std::string> words;
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) words.push_back(MotorAxisName(i));
  return words;
}

// axis: x, or axes: [x, y].
void ReadStepAxes(std::string_view name,
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

// The unit in keys: mm, or deg where every axis is rotary.
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

// Keys end in the unit of the axes: safe_mm, safe_deg, fine_deg_s. No length exceeds
// the shortest travel.
void ReadLengths(std::string_view name,
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

void ReadNumbers(std::string_view name, YamlMap* map, MotorOptions* o) {
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

MotorOptions ReadMotorStageOptions(std::string_view name,
                                   const MotorStageDrawing& drawing,
                                   YamlMap* map) {
  MotorOptions o;
  // What was published of the stop is a wish, no procedure that could be followed.
  if (name != "emergency_stop") {
    o.is_as_published =
        map->WordOr("variant", "corrected", {"as_published", "corrected"}) ==
        "as_published";
  }
  ReadStepAxes(name, drawing, map, &o);
  ReadLengths(name, UnitKey(o, drawing), ReachOf(o, drawing), map, &o);
  ReadNumbers(name, map, &o);
  if (name == "motor_backlash" && o.distance_unit <= 2 * o.tolerance_unit) {
    map->faults()->Add(
        map->place(),
        map->path() +
            fmt::format(" goes {:g} from either side, not more than twice its "
                        "tolerance of {:g}",
                        o.distance_unit,
                        o.tolerance_unit),
        "a gap of the tolerance would not be crossed");
  }
  o.retries = static_cast<int>(map->IntegerOr("retries", o.retries, 0, 10));
  map->NoMoreKeys();
  return o;
}

// What the engine knows of the stage, from one procedure to the next.
MotorAxes* AxesOn(Bench* bench) {
  if (auto* const kept = bench->kept.Find<MotorAxes>()) return kept;
  return bench->kept.Put(MotorAxes({.link = bench->link,
                                    .gauge = bench->gauge,
                                    .drawing = MotorStageOf(bench->machine)}));
}

std::map<std::string, double> FiguresOf(const MotorFindings& found) {
  std::map<std::string, double> figures = {{"alerts", found.alerts},
                                           {"retries", found.retries},
                                           {"warnings", found.warnings},
                                           {"safe_modes", found.safe_modes},
                                           {"positions_lost", found.positions_lost}};
  const auto add = [&](const char* name, const auto& value, double unit = 1) {
    if (value) figures[name] = static_cast<double>(*value) / unit;
  };
  add("index_edges", found.index_edges);
  add("wrong_turn_probability", found.wrong_turn_probability);
  add("skew_ms", found.skew_s, SFromMs(1.0));
  add("stop_feasible", found.stop_feasible);
  add("standstill_ms", found.standstill_s, SFromMs(1.0));
  add("stopped_within", found.stopped_within);
  return figures;
}

// They home, move and store by nature: the person is asked before.
ProcedureResult MotorStageOnBench(const NamedProcedure& procedure,
                                  const MotorOptions& options,
                                  Bench* bench) {
  const auto agreed = bench->person->Do(
      {.kind = Act::Kind::kConfirm,
       .text =
           fmt::format("{}: move the axis and store what is found?", procedure.name)});
  if (!agreed) return {.ending = Ending::kRefused, .messages = {"not done"}};
  const MotorResult done = procedure.run(AxesOn(bench), options);
  ProcedureResult result = done.result;
  result.figures = FiguresOf(done.found);
  return result;
}

template <std::size_t kIndex>
PreparedProcedure PrepareMotorStage(YamlMap map, const Machine& drawing) {
  const MotorOptions options =
      ReadMotorStageOptions(kNamed[kIndex].name, MotorStageOf(drawing), &map);
  return [options](Bench* bench) {
    return MotorStageOnBench(kNamed[kIndex], options, bench);
  };
}

constexpr std::array kMotorStageCatalog = {
    Procedure{.name = "servo_home",
              .about =
                  "Homes a servo: to the MIN switch at slow (0.1 of the highest "
                  "speed), back off by back_off_mm (2), on to the first index pulse; "
                  "that is zero. as_published takes where the axis stopped; corrected "
                  "the latched count, warns where the switch's scatter can reach the "
                  "index and backs off by half a turn more, looks at the switch again "
                  "where the index is near the place that decides on its turn, and "
                  "counts turns from a stored home offset. Lengths of a rotary axis "
                  "are back_off_deg, likewise below. Troubles are logged and tried "
                  "again at half the speed, retries times (2); then the operator is "
                  "called and the axis is put in safe mode.",
              .has_variants = true,
              .prepare = PrepareMotorStage<0>,
              .kind = kMotorStageKind},
    Procedure{.name = "index_verify",
              .about =
                  "One turn of the motor has one index pulse, and the counter is "
                  "within threshold_pulses (3) of it. as_published starts on the index"
                  " and counts 0, 1 or 2; corrected starts half a turn off. At half "
                  "the speed where it fails.",
              .has_variants = true,
              .prepare = PrepareMotorStage<1>,
              .kind = kMotorStageKind},
    Procedure{.name = "stepper_home",
              .about =
                  "Homes an open-loop stepper on its MIN switch: slow, back off by "
                  "back_off_mm (5), again at second (0.5) of the speed, back off by "
                  "final_back_off_mm (1) to zero, rest at safe_mm (10) from the "
                  "switch. corrected touches it touches (5) times at fine_mm_s (0.5) "
                  "and takes the mean; of an axis homed before it tells the steps it "
                  "had lost.",
              .has_variants = true,
              .prepare = PrepareMotorStage<2>,
              .kind = kMotorStageKind},
    Procedure{.name = "travel_limits",
              .about = "From home to the MAX switch: the travel, and software limits "
                       "margin_mm (2) within it.",
              .has_variants = true,
              .prepare = PrepareMotorStage<3>,
              .kind = kMotorStageKind},
    Procedure{.name = "axis_sync",
              .about =
                  "Moves axes together and reads from their counters when each was "
                  "half way. axes: [x, y], distance_mm (10), repeats (3), medium "
                  "(0.5). corrected sets the delays that align them and looks again. "
                  "Of open-loop steppers nothing is known.",
              .has_variants = true,
              .takes_axes = TakesSeveralAxes("axis_sync"),
              .prepare = PrepareMotorStage<4>,
              .kind = kMotorStageKind},
    Procedure{.name = "emergency_stop",
              .about =
                  "Foretells from inertia, speed (medium, 0.5) and current whether "
                  "each of axes stands within_ms (5), its load coasting across the gap"
                  " that motor_backlash measured; a gap that nobody measured, of "
                  "tolerance_mm (0.2), is asked for where it would matter. Stops them "
                  "in mid-motion, reads time, way and current of each, then resumes: a"
                  " servo shows at its index whether its position was kept (but for "
                  "whole turns), a stepper is homed again and shows its lost steps.",
              .takes_axes = TakesSeveralAxes("emergency_stop"),
              .prepare = PrepareMotorStage<5>,
              .kind = kMotorStageKind},
    Procedure{.name = "motor_backlash",
              .about =
                  "The gap between motor and carriage. as_published reads the motor's "
                  "own counter twice: distance_mm (10) for any gap. corrected "
                  "approaches one place from both sides and reads a gauge "
                  "(instruments: {laser: {sigma_um: 0.5}}); beyond tolerance_mm (0.2) "
                  "the operator is called.",
              .has_variants = true,
              .prepare = PrepareMotorStage<6>,
              .kind = kMotorStageKind}};

}  // namespace

std::span<const Procedure> MotorProcedures() {
  return kMotorStageCatalog;
}

}  // namespace caltwin

#include "scenarios/z_offset_scenario.h"

#include <algorithm>
#include <array>

#include "scenarios/named_step.h"

namespace caltwin {
namespace {

struct StationKey {
  const char* key;
  Bounds bounds;
  double ZStation::*member;
};

constexpr std::array kKeys = {
    StationKey{"switch_mm", {-20, 50}, &ZStation::switch_mm},
    StationKey{"nozzle_mm", {-5, 5}, &ZStation::nozzle_mm},
    StationKey{"ooze_mm", {0, 5}, &ZStation::ooze_mm},
    StationKey{"body_mm", {0, 50}, &ZStation::body_mm},
    StationKey{"trigger_mm", {-1, 5}, &ZStation::trigger_mm},
    StationKey{"plate_mm", {0, 20}, &ZStation::plate_mm},
    StationKey{"endstop_scatter_mm", {0, 1}, &ZStation::endstop_scatter_mm},
    StationKey{"probe_scatter_mm", {0, 1}, &ZStation::probe_scatter_mm},
    StationKey{"worn_mm", {0, 2}, &ZStation::worn_mm},
    StationKey{"nozzle_mm_per_k", {-0.1, 0.1}, &ZStation::nozzle_mm_per_k},
    StationKey{"bed_mm_per_k", {-0.1, 0.1}, &ZStation::bed_mm_per_k},
    StationKey{"frame_mm_per_k", {-0.1, 0.1}, &ZStation::frame_mm_per_k}};

constexpr std::array<std::string_view, 5> kSteps = {
    "z_calibration", "probe_accuracy", "switch_offset", "gcode", "change"};

}  // namespace

std::vector<StationSpec> ReadStation(YamlMap map) {
  std::vector<StationSpec> specs;
  for (const StationKey& key : kKeys) {
    if (const auto value = map.Optional(key.key)) {
      specs.push_back({key.key, value->NumberOrDistribution(key.bounds)});
    }
  }
  map.NoMoreKeys();
  return specs;
}

namespace {

ZCalibrationConfig ReadConfig(YamlMap map) {
  ZCalibrationConfig c;
  c.position_endstop_mm = map.NumberOr("position_endstop_mm", 0, {-50, 500});
  c.switch_offset_mm = map.NumberOr("switch_offset_mm", c.switch_offset_mm, {-10, 10});
  c.samples = static_cast<int>(map.IntegerOr("samples", 3, 1, 100));
  c.samples_tolerance_mm =
      map.NumberOr("samples_tolerance_mm", c.samples_tolerance_mm, {0, 10});
  c.samples_tolerance_retries =
      static_cast<int>(map.IntegerOr("samples_tolerance_retries", 0, 0, 100));
  c.takes_median =
      map.WordOr("samples_result", "average", {"average", "median"}) == "median";
  c.probing_speed_mm_s = map.NumberOr("probing_speed_mm_s", 5, {0.1, 100});
  c.lifting_speed_mm_s = map.NumberOr("lifting_speed_mm_s", 5, {0.1, 100});
  c.retract_mm = map.NumberOr("sample_retract_dist_mm", 2, {0.1, 50});
  c.position_min_mm = map.NumberOr("position_min_mm", -5, {-50, 0});
  c.start_gcode = map.TextOr("start_gcode", "");
  c.before_switch_gcode = map.TextOr("before_switch_gcode", "ATTACH_PROBE");
  c.end_gcode = map.TextOr("end_gcode", "DETACH_PROBE");
  if (const auto flag = map.Optional("is_virtual_endstop")) {
    c.is_virtual_endstop = flag->Flag();
  }
  map.NoMoreKeys();
  return c;
}

ZOffsetStep ReadStep(const std::string& name, const YamlValue& value) {
  ZOffsetStep step{.name = name};
  if (value.is_null()) return step;
  YamlMap map = value.Map();
  if (name == "gcode") {
    if (const auto lines = map.Required("lines")) {
      for (const YamlValue& line : lines->List()) step.lines.push_back(line.Text());
    }
    map.NoMoreKeys();
    return step;
  }
  if (name == "change") {
    step.change = ReadStation(std::move(map));
    return step;
  }
  if (name == "probe_accuracy") {
    step.samples = static_cast<int>(map.IntegerOr("samples", 10, 1, 10'000));
    step.is_endstop = map.WordOr("of", "endstop", {"endstop", "probe"}) == "endstop";
  }
  if (name == "switch_offset") {
    if (const auto flag = map.Optional("apply")) step.applies = flag->Flag();
  }
  map.NoMoreKeys();
  return step;
}

std::vector<ZOffsetStep> ReadSteps(const YamlValue& list) {
  std::vector<ZOffsetStep> steps;
  for (const NamedStep& step :
       ReadNamedSteps(list, kSteps, "step of a nozzle's height")) {
    steps.push_back(ReadStep(step.name, step.options));
  }
  return steps;
}

void ReadExpectation(YamlMap map, ZOffsetScenario* scenario) {
  scenario->outcome = map.WordOr(
      "outcome", "recovers", {"recovers", "misses", "refused", "no_trigger"});
  for (const char* figure :
       {"z_offset_error_mm", "gcode_offset_mm", "switch_offset_mm", "machine_time_s"}) {
    const auto value = map.Optional(figure);
    if (!value) continue;
    YamlMap bounds = value->Map();
    Within within;
    if (const auto above = bounds.Optional("above")) within.above = above->Number();
    if (const auto below = bounds.Optional("below")) within.below = below->Number();
    bounds.NoMoreKeys();
    scenario->figures.emplace_back(figure, within);
  }
  if (const auto messages = map.Optional("messages")) {
    for (const YamlValue& text : messages->List()) {
      scenario->messages.push_back(text.Text());
    }
  }
  map.NoMoreKeys();
}

}  // namespace

ZOffsetScenario ReadZOffsetScenario(YamlMap* map) {
  ZOffsetScenario scenario;
  if (const auto station = map->Optional("station")) {
    scenario.station = ReadStation(station->Map());
  }
  if (const auto settings = map->Optional("settings")) {
    scenario.settings = ReadConfig(settings->Map());
  }
  if (const auto calibrate = map->Required("calibrate")) {
    scenario.calibrate = ReadSteps(*calibrate);
  }
  if (const auto expect = map->Optional("expect")) {
    ReadExpectation(expect->Map(), &scenario);
  }
  return scenario;
}

void SetStation(const std::vector<StationSpec>& specs,
                std::uint64_t seed,
                std::uint64_t sample,
                ZStation* station) {
  for (const StationSpec& spec : specs) {
    const auto key = std::ranges::find_if(
        kKeys, [&](const StationKey& one) { return spec.key == one.key; });
    Rng rng(seed, sample, "station." + spec.key);
    station->*key->member = Draw(spec.value, &rng);
  }
}

}  // namespace caltwin

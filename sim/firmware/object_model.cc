#include <cmath>

#include <nlohmann/json.hpp>

#include "sim/base/input_error.h"
#include "sim/firmware/model_path.h"
#include "sim/firmware/parts.h"

namespace caltwin {
namespace {

using Json = nlohmann::ordered_json;
using rrf::Value;

/// To so many decimals, as RepRapFirmware prints it.
double Rounded(double value, int decimals) {
  const double scale = std::pow(10, decimals);
  return std::round(value * scale) / scale + 0.0;
}

Json JsonFrom(const Value& value) {
  if (const auto* flag = std::get_if<bool>(&value.of)) return *flag;
  if (const auto* whole = std::get_if<std::int64_t>(&value.of)) return *whole;
  if (const auto* number = std::get_if<double>(&value.of)) return *number;
  if (const auto* text = std::get_if<std::string>(&value.of)) return *text;
  if (const auto* array = value.array()) {
    Json elements = Json::array();
    for (const Value& element : *array) elements.push_back(JsonFrom(element));
    return elements;
  }
  return nullptr;
}

Value ValueFrom(const Json& json) {
  if (json.is_boolean()) return Value{json.get<bool>()};
  if (json.is_number_integer()) return Value{json.get<std::int64_t>()};
  if (json.is_number()) return Value{json.get<double>()};
  if (json.is_string()) return Value{json.get<std::string>()};
  if (json.is_array()) {
    Value::Array elements;
    for (const Json& element : json) elements.push_back(ValueFrom(element));
    return Value{std::move(elements)};
  }
  if (json.is_object()) return Value{std::string("{object}")};
  return Value{};
}

}  // namespace

Json Firmware::Parts::AxisModel(Axis axis) {
  const int i = Index(axis);
  const AxisDrawing& drawing = machine.axis(axis);
  Json offsets = Json::array();
  for (const Vec3<double>& offset : workplaces_mm) {
    offsets.push_back(Rounded(offset[i], 3));
  }
  return {{"acceleration", drawing.acceleration_mm_s2},
          {"babystep", 0},
          {"backlash", Rounded(settings.backlash_mm[i], 6)},
          {"homed", motion.is_homed(axis)},
          {"jerk", FeedWord_mm_min(motion.limits().jerk_mm_s[i])},
          {"letter", std::string(1, CapitalLetter(axis))},
          {"machinePosition", Rounded(motion.counted_mm()[i], 3)},
          {"max", drawing.max_mm},
          {"min", drawing.min_mm},
          {"speed", FeedWord_mm_min(drawing.max_feed_mm_s)},
          {"stepsPerMm", Rounded(settings.steps_per_mm[i], 6)},
          {"userPosition", Rounded(motion.commanded_mm()[i] - offset_mm()[i], 3)},
          {"visible", true},
          {"workplaceOffsets", offsets}};
}

Json Firmware::Parts::ProbesModel() const {
  if (!HasProbe()) return Json::array();
  Json speeds = Json::array();
  for (const double speed_mm_s : machine.probe.speeds_mm_s) {
    speeds.push_back(FeedWord_mm_min(speed_mm_s));
  }
  const double travel_mm_s = machine.axis(Axis::kX).max_feed_mm_s;
  return Json::array({{{"diveHeights", Json::array({5.0, 5.0})},
                       {"maxProbeCount", 1},
                       {"offsets", Json::array({0.0, 0.0})},
                       {"recoveryTime", options.probe_recovery_s},
                       {"speeds", speeds},
                       {"travelSpeed", FeedWord_mm_min(travel_mm_s)},
                       {"type", 8},
                       {"value", Json::array({ProbeReads() ? 1000 : 0})}}});
}

Json Firmware::Parts::ObjectModel() {
  Json axes = Json::array();
  for (const Axis axis : kAxes) axes.push_back(AxisModel(axis));
  Json variables = Json::object();
  for (const auto& [name, value] : globals) variables[name] = JsonFrom(value);
  const bool is_off = is_halted();
  return {{"boards",
           Json::array({{{"firmwareName", "RepRapFirmware dialect of caltwin"},
                         {"firmwareVersion",
                          options.m400_ignores_backlash ? "3.6.0" : "3.6.1"}}})},
          {"global", variables},
          {"inputs", Json::array({{{"active", true}, {"name", "USB"}}})},
          {"limits",
           {{"axes", 3}, {"probes", 1}, {"tools", 1}, {"workplaces", kWorkplaces}}},
          {"move",
           {{"axes", axes},
            {"backlashFactor", motion.backlash_factor()},
            {"workplaceNumber", workplace}}},
          {"sensors", {{"probes", ProbesModel()}}},
          {"spindles", Json::array()},
          {"state",
           {{"currentTool", tool},
            {"machineMode", "CNC"},
            {"messageBox", nullptr},
            {"status", is_off ? "halted" : "idle"},
            {"thisInput", 0},
            {"upTime", std::floor(motion.time_s())}}},
          {"tools",
           Json::array({{{"name", "touch probe"},
                         {"number", 0},
                         {"offsets", Json::array({0.0, 0.0, 0.0})}}})}};
}

std::optional<Value> Firmware::Parts::LookUp(const rrf::Path& path, Frame* frame) {
  const auto& root = std::get<std::string>(path[0]);
  if (path.size() == 1 && root == "iterations") return frame->Iterations();
  const bool is_scoped =
      path.size() >= 2 && std::holds_alternative<std::string>(path[1]);
  if (is_scoped && (root == "global" || root == "var" || root == "param")) {
    const auto& name = std::get<std::string>(path[1]);
    const Value* found = nullptr;
    if (root == "var") found = frame->FindVariable(name);
    if (root == "global" && globals.contains(name)) found = &globals.at(name);
    if (root == "param" && frame->params.contains(name)) {
      found = &frame->params.at(name);
    }
    if (found == nullptr) return std::nullopt;
    return Element(*found, path, 2);
  }
  motion.Finish();
  const Json found = FindInModel(ObjectModel(), rrf::ToText(path));
  if (found.is_null()) return std::nullopt;
  return ValueFrom(found);
}

}  // namespace caltwin

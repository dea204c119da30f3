#include "scenarios/parameter_name.h"

#include <array>

#include "sim/effects/catalog.h"
#include "sim/effects/injected.h"

namespace caltwin {
namespace {

// Calls `visit(id, name)` for every parameter until it answers true.
template <typename Visit>
void ForEachParameter(Visit visit) {
  for (std::size_t effect = 0; effect < AllEffects().size(); ++effect) {
    const Effect& declaration = *AllEffects()[effect];
    for (const std::string_view axis : declaration.axes) {
      for (std::size_t i = 0; i < declaration.parameters.size(); ++i) {
        const ParameterId id{.effect = static_cast<int>(effect),
                             .axis = std::string(axis),
                             .parameter = i,
                             .unit = declaration.parameters[i].unit};
        if (visit(id, ParameterName(id.effect, axis, i))) return;
      }
    }
  }
}

struct Setting {
  std::string_view cause;
  std::array<double, 3> Settings::*values;
};
constexpr std::array kSettings = {
    Setting{"steps_per_mm", &Settings::steps_per_mm},
    Setting{"backlash", &Settings::backlash_mm},
    Setting{"probe_pretravel", &Settings::probe_deflection_mm}};

}  // namespace

std::optional<ParameterId> FindParameter(std::string_view name) {
  std::optional<ParameterId> found;
  ForEachParameter([&](const ParameterId& id, const std::string& candidate) {
    if (candidate == name) found = id;
    return found.has_value();
  });
  return found;
}

std::vector<std::string> AllParameterNames() {
  std::vector<std::string> names;
  ForEachParameter([&](const ParameterId&, const std::string& name) {
    names.push_back(name);
    return false;
  });
  return names;
}

std::optional<double> BuiltValueNamed(const Machine& machine,
                                      const std::vector<Injected>& effects,
                                      std::string_view name) {
  const auto id = FindParameter(name);
  if (!id) return std::nullopt;
  return BuiltValue(machine, effects, id->effect, id->axis, id->parameter);
}

std::optional<double> SettingNamed(const Settings& settings, std::string_view name) {
  const std::size_t dot = name.find('.');
  if (dot == std::string_view::npos) return std::nullopt;
  const auto axis = AxisNamed(name.substr(dot + 1));
  if (!axis) return std::nullopt;
  for (const Setting& setting : kSettings) {
    if (setting.cause == name.substr(0, dot)) {
      return (settings.*setting.values)[Index(*axis)];
    }
  }
  return std::nullopt;
}

std::vector<std::string> SettingNames() {
  std::vector<std::string> names;
  for (const Setting& setting : kSettings) {
    for (const Axis axis : kAxes) {
      names.push_back(std::string(setting.cause) + "." + Name(axis));
    }
  }
  return names;
}

}  // namespace caltwin

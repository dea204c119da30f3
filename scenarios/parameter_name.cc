#include "scenarios/parameter_name.h"

#include <array>

#include "sim/effects/catalog.h"
#include "sim/effects/drive.h"
#include "sim/effects/injected.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

// Calls `visit(id, name)` for every parameter until it answers true.
template <typename Visit>
void ForEachParameter(const MachineKind* kind, Visit visit) {
  for (std::size_t effect = 0; effect < AllEffects().size(); ++effect) {
    const Effect& declaration = *AllEffects()[effect];
    for (const std::string_view axis : AxesOn(declaration, kind)) {
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
  bool is_drive = true;
};
constexpr std::array kSettings = {
    Setting{"steps_per_mm", &Settings::steps_per_mm},
    Setting{"backlash", &Settings::backlash_mm},
    Setting{"probe_pretravel", &Settings::probe_deflection_mm, false}};

}  // namespace

std::optional<ParameterId> FindParameter(std::string_view name,
                                         const MachineKind* kind) {
  std::optional<ParameterId> found;
  ForEachParameter(kind, [&](const ParameterId& id, const std::string& candidate) {
    if (candidate == name) found = id;
    return found.has_value();
  });
  return found;
}

std::vector<std::string> AllParameterNames(const MachineKind* kind) {
  std::vector<std::string> names;
  ForEachParameter(kind, [&](const ParameterId&, const std::string& name) {
    names.push_back(name);
    return false;
  });
  return names;
}

std::optional<double> BuiltValueNamed(const Machine& machine,
                                      const std::vector<Injected>& effects,
                                      std::string_view name) {
  const auto id = FindParameter(name, machine.kind);
  if (!id) return std::nullopt;
  return BuiltValue(machine, effects, id->effect, id->axis, id->parameter);
}

std::optional<double> SettingNamed(const Settings& settings, std::string_view name) {
  const std::size_t dot = name.find('.');
  if (dot == std::string_view::npos) return std::nullopt;
  const auto drive = DriveNamed(name.substr(dot + 1));
  if (!drive || name.size() != dot + 2) return std::nullopt;
  for (const Setting& setting : kSettings) {
    if (setting.cause == name.substr(0, dot)) {
      return (settings.*setting.values)[drive->slot()];
    }
  }
  return std::nullopt;
}

std::vector<std::string> SettingNames(const MachineKind* kind) {
  std::vector<std::string> names;
  for (const Setting& setting : kSettings) {
    for (const Axis axis : kAxes) {
      const DriveMap* drives = setting.is_drive ? kind->drive_map() : nullptr;
      names.push_back(std::string(setting.cause) + "." +
                      DriveName(drives, Index(axis)));
    }
  }
  return names;
}

}  // namespace caltwin

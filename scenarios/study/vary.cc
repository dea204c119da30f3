#include "scenarios/study/vary.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "scenarios/motor_effects.h"
#include "sim/effects/catalog.h"

namespace caltwin {
namespace {

constexpr std::string_view kOfSettings = "settings.";

// In two at that dot.
std::pair<std::string, std::string> Parted(const std::string& name, std::size_t dot) {
  if (dot == std::string::npos) return {name, ""};
  return {name.substr(0, dot), name.substr(dot + 1)};
}

// The values that `varied` gives replace those of the same effect on the same axis.
void Replace(const InjectedSpec& varied,
             const std::string& parameter,
             std::vector<InjectedSpec>* effects) {
  const auto found = std::ranges::find_if(*effects, [&](const InjectedSpec& spec) {
    return spec.effect == varied.effect && spec.axis == varied.axis;
  });
  if (found == effects->end()) {
    effects->push_back(varied);
    return;
  }
  const auto parameters = EffectAt(varied.effect).parameters;
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    if (parameters[p].name == parameter) found->values[p] = varied.values[p];
  }
}

// Every effect that the scenario's machine may have.
std::vector<std::string> NamesFor(const Scenario& scenario) {
  if (scenario.delta) return DeltaEffectNames();
  if (scenario.motor) return MotorEffectNames();
  if (scenario.z_offset) return {"station"};
  std::vector<std::string> names;
  for (const Effect* effect : AllEffects()) names.emplace_back(effect->name);
  return names;
}

void VaryDelta(const DeltaEffects& varied,
               const std::string& parameter,
               DeltaEffects* effects) {
  for (const DeltaInjected& part : varied.parts) {
    std::erase_if(effects->parts, [&](const DeltaInjected& had) {
      return had.name == part.name && had.parameter == part.parameter;
    });
    effects->parts.push_back(part);
  }
  for (const InjectedSpec& spec : varied.effects) {
    Replace(spec, parameter, &effects->effects);
  }
}

void VaryMotor(const std::vector<MotorEffectSpec>& varied, MotorScenario* scenario) {
  for (const MotorEffectSpec& spec : varied) {
    std::erase_if(scenario->effects, [&](const MotorEffectSpec& had) {
      return had.effect == spec.effect && had.parameter == spec.parameter &&
             had.axis == spec.axis;
    });
    scenario->effects.push_back(spec);
  }
}

void VaryStation(const std::vector<StationSpec>& varied, ZOffsetScenario* scenario) {
  for (const StationSpec& spec : varied) {
    std::erase_if(scenario->station,
                  [&](const StationSpec& had) { return had.key == spec.key; });
    scenario->station.push_back(spec);
  }
}

// `effect` of a printer, a motor stage or a station; false: of a gantry.
bool VaryOther(const std::string& effect,
               const std::string& parameter,
               const YamlValue& value,
               Scenario* scenario) {
  const Machine& machine = scenario->machine.machine;
  const YamlMap nested = value.Within(effect, parameter);
  if (scenario->delta) {
    VaryDelta(ReadDeltaEffects(nested, machine), parameter, &scenario->delta->effects);
  } else if (scenario->motor) {
    VaryMotor(ReadMotorEffects(nested, scenario->motor->drawing), &*scenario->motor);
  } else if (scenario->z_offset) {
    VaryStation(ReadStation(value.Within(parameter)), &*scenario->z_offset);
  } else {
    return false;
  }
  return true;
}

bool IsPrinterOrStage(const Scenario& scenario) {
  return scenario.delta || scenario.triple_z || scenario.motor || scenario.z_offset;
}

void VarySetting(const SettingSpec& varied, std::vector<SettingSpec>* settings) {
  std::erase_if(*settings, [&](const SettingSpec& had) {
    return had.key == varied.key && had.axis == varied.axis;
  });
  settings->push_back(varied);
}

void VaryNumber(const std::string& name, const YamlValue& value, Scenario* scenario) {
  if (IsPrinterOrStage(*scenario)) {
    value.Fail("is not known of this machine", "vary its effects");
    return;
  }
  scenario->varied.push_back(
      ReadVariedNumber(name, value, scenario->instruments, scenario->artefacts));
}

}  // namespace

void Vary(YamlMap vary, Scenario* scenario) {
  for (const auto& [name, value] : vary.Entries()) {
    if (name.starts_with(kOfSettings)) {
      if (IsPrinterOrStage(*scenario)) {
        value.Fail("is not known of this machine", "vary its effects");
        continue;
      }
      const std::string key = name.substr(kOfSettings.size());
      const auto [setting, axis] = Parted(key, key.find('.'));
      for (const SettingSpec& spec : ReadSettingSpecs(value.Within(setting, axis))) {
        VarySetting(spec, &scenario->settings);
      }
      continue;
    }
    if (IsVariedNumber(name)) {
      VaryNumber(name, value, scenario);
      continue;
    }
    const auto [effect, parameter] = Parted(name, name.rfind('.'));
    if (parameter.empty()) {
      value.Fail("names no parameter",
                 "write CAUSE.AXIS.PARAMETER, as in `backlash.x.gap_mm`");
      continue;
    }
    const std::string cause = effect.substr(0, effect.find('.'));
    const std::vector<std::string> known = NamesFor(*scenario);
    if (std::ranges::find(known, cause) == known.end()) {
      const std::string nearest = NearestWord(cause, known);
      value.Fail("names no effect of this machine",
                 (nearest.empty() ? "" : fmt::format("did you mean '{}'? ", nearest)) +
                     "`caltwin explain` lists them all");
      continue;
    }
    if (VaryOther(effect, parameter, value, scenario)) continue;
    auto& effects =
        scenario->triple_z ? scenario->triple_z->effects : scenario->effects;
    const YamlMap nested = value.Within(effect, parameter);
    for (const InjectedSpec& spec : ReadEffects(nested, scenario->machine.machine)) {
      Replace(spec, parameter, &effects);
    }
  }
}

}  // namespace caltwin

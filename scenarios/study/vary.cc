#include "scenarios/study/vary.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace caltwin {
namespace {

constexpr std::string_view kOfSettings = "settings.";

// In two at that dot.
std::pair<std::string, std::string> Parted(const std::string& name, std::size_t dot) {
  if (dot == std::string::npos) return {name, ""};
  return {name.substr(0, dot), name.substr(dot + 1)};
}

void VarySetting(const SettingSpec& varied, std::vector<SettingSpec>* settings) {
  std::erase_if(*settings, [&](const SettingSpec& had) {
    return had.key == varied.key && had.axis == varied.axis;
  });
  settings->push_back(varied);
}

void VaryNumber(const std::string& name, const YamlValue& value, Scenario* scenario) {
  if (!scenario->kind->VariesMore()) {
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
      if (!scenario->kind->VariesMore()) {
        value.Fail("is not known of this machine", "vary its effects");
        continue;
      }
      const std::string key = name.substr(kOfSettings.size());
      const auto [setting, axis] = Parted(key, key.find('.'));
      for (const SettingSpec& spec : ReadSettingSpecs(
               value.Within(setting, axis), *scenario->machine.machine.kind)) {
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
    const std::vector<std::string> known = scenario->kind->EffectNames();
    if (std::ranges::find(known, cause) == known.end()) {
      const std::string nearest = NearestWord(cause, known);
      value.Fail("names no effect of this machine",
                 (nearest.empty() ? "" : fmt::format("did you mean '{}'? ", nearest)) +
                     "`caltwin explain` lists them all");
      continue;
    }
    scenario->kind->Vary(effect, parameter, value, scenario);
  }
}

}  // namespace caltwin

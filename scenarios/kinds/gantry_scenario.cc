#include "scenarios/kinds/gantry_scenario.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scenarios/kinds/gantry_klipper_trial.h"
#include "scenarios/kinds/gantry_linuxcnc_trial.h"
#include "scenarios/kinds/gantry_trial.h"
#include "scenarios/parameter_name.h"
#include "sim/effects/catalog.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

void RefuseTwice(const std::vector<InjectedSpec>& specs, Faults* faults) {
  for (std::size_t i = 0; i < specs.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (specs[i].effect != specs[j].effect || specs[i].axis != specs[j].axis)
        continue;
      faults->Add(specs[i].place,
                  "this effect is already in the machine file",
                  "an effect is given once: leave it out here or there");
    }
  }
}

FirmwareOptions ReadFirmware(YamlMap map) {
  FirmwareOptions options;
  options.m400_ignores_backlash = map.FlagOr("m400_ignores_backlash", false);
  options.probe = ReadProbeInput(&map);
  if (const auto files = map.Optional("files")) {
    for (const auto& [path, text] : files->Map().Entries()) {
      options.files[path] = text.Text();
    }
  }
  map.NoMoreKeys();
  return options;
}

}  // namespace

ProbeInput ReadProbeInput(YamlMap* map) {
  const std::string word =
      map->WordOr("probe", "wired", {"wired", "missing", "open", "stuck"});
  return word == "missing" ? ProbeInput::kMissing
         : word == "open"  ? ProbeInput::kOpen
         : word == "stuck" ? ProbeInput::kStuck
                           : ProbeInput::kWired;
}

void GantryScenario::ReadKeys(YamlMap* map, Scenario* scenario) {
  machine_kind_ = scenario->machine.machine.kind;
  if (const auto effects = map->Optional("effects")) {
    const auto more = ReadEffects(effects->Map(), scenario->machine.machine);
    scenario->effects.insert(scenario->effects.end(), more.begin(), more.end());
    RefuseTwice(scenario->effects, map->faults());
  }
  if (const auto settings = map->Optional("settings")) {
    scenario->settings = ReadSettingSpecs(settings->Map(), *machine_kind_);
  }
  if (const auto instruments = map->Optional("instruments")) {
    scenario->instruments = ReadInstruments(instruments->Map());
  }
  if (const auto artefacts = map->Optional("artefacts")) {
    scenario->artefacts = ReadArtefacts(artefacts->Map());
  }
  RefuseUnknownArtefacts(scenario->effects, IdsOf(scenario->artefacts), map->faults());
  if (const auto firmware = map->Optional("firmware")) {
    scenario->firmware = ReadFirmware(firmware->Map());
  }
}

Procedures GantryScenario::KnownProcedures() const {
  return ProceduresFor(*machine_kind_);
}

Expectable GantryScenario::CanExpect() const {
  return {.parameters = AllParameterNames(machine_kind_),
          .figures = {"position_error_mm.p95",
                      "position_error_mm.rms",
                      "position_error_mm.most",
                      "zero_shift_mm",
                      "flatness_mm.rms",
                      "mesh_error_mm.rms",
                      "mesh_error_mm.most"}};
}

std::vector<std::string> GantryScenario::EffectNames() const {
  std::vector<std::string> names;
  for (const Effect* effect : AllEffects()) {
    const bool is_there =
        machine_kind_ == CartesianKind() || !AxesOn(*effect, machine_kind_).empty();
    if (is_there) names.emplace_back(effect->name);
  }
  return names;
}

void GantryScenario::Vary(const std::string& effect,
                          const std::string& parameter,
                          const YamlValue& value,
                          Scenario* scenario) {
  VaryEffects(effect, parameter, value, scenario->machine.machine, &scenario->effects);
}

void GantryScenario::CheckVaried(const Scenario& scenario, Faults* faults) const {
  RefuseUnknownArtefacts(scenario.effects, IdsOf(scenario.artefacts), faults);
}

std::unique_ptr<KindTrial> GantryScenario::BeginUnderKlipper(
    const Scenario& scenario, const Chance& chance) const {
  return BeginGantryUnderKlipper(scenario, chance);
}

std::unique_ptr<KindTrial> GantryScenario::BeginUnderLinuxCnc(
    const Scenario& scenario, const Chance& chance) const {
  return BeginGantryUnderLinuxCnc(scenario, chance);
}

std::unique_ptr<KindTrial> GantryScenario::Begin(const Scenario& scenario,
                                                 const Chance& chance) const {
  return std::make_unique<GantryTrial>(scenario, chance);
}

void ReplaceEffect(const InjectedSpec& varied,
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

void VaryEffects(const std::string& effect,
                 const std::string& parameter,
                 const YamlValue& value,
                 const Machine& machine,
                 std::vector<InjectedSpec>* effects) {
  for (const InjectedSpec& spec :
       ReadEffects(value.Within(effect, parameter), machine)) {
    ReplaceEffect(spec, parameter, effects);
  }
}

}  // namespace caltwin

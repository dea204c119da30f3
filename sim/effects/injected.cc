#include "sim/effects/injected.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/effects/catalog.h"
#include "sim/effects/predict.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

constexpr Bounds kTableBounds_um{-10000, 10000};

std::vector<std::string> KnownCauses(const MachineKind* kind) {
  std::vector<std::string> names;
  for (const Effect* effect : AllEffects()) {
    for (const std::string_view axis : AxesOn(*effect, kind)) {
      names.push_back(axis.empty() ? std::string(effect->name)
                                   : fmt::format("{}.{}", effect->name, axis));
    }
  }
  return names;
}

bool ReadName(const std::string& key,
              const YamlValue& value,
              const MachineKind* kind,
              InjectedSpec* spec) {
  const std::size_t dot = key.find('.');
  const std::string cause = key.substr(0, dot);
  spec->axis = dot == std::string::npos ? "" : key.substr(dot + 1);
  const std::optional<int> effect = FindEffect(cause);
  if (!effect || AxesOn(EffectAt(*effect), kind).empty()) {
    const std::string nearest = NearestWord(key, KnownCauses(kind));
    value.Fail(effect ? fmt::format("is no effect of a {} machine", kind->name())
                      : "is no effect that this version can inject",
               (nearest.empty() ? "" : fmt::format("did you mean '{}'? ", nearest)) +
                   "`caltwin explain` lists them all");
    return false;
  }
  spec->effect = *effect;
  const auto axes = AxesOn(EffectAt(*effect), kind);
  if (HasAxis(EffectAt(*effect), spec->axis, kind)) {
    spec->axis = AxisOf(EffectAt(*effect), spec->axis);
    return true;
  }
  value.Fail(
      spec->axis.empty() ? "needs an axis"
                         : fmt::format("has no axis '{}'", spec->axis),
      axes.size() == 1 && axes[0].empty()
          ? fmt::format("write `{}:` alone, it has no axis", cause)
          : fmt::format(
                "write {}.{}; it may be: {}", cause, axes[0], fmt::join(axes, ", ")));
  return false;
}

std::vector<Distribution> ReadTable(YamlMap* map) {
  const auto knots = map->Required("knots_mm");
  const auto values = map->Required("values_um");
  if (!knots || !values) return {};
  const std::vector<double> knots_mm = ReadKnots(*knots);
  const auto flat =
      FlatMap(values->Numbers(knots_mm.size(), kTableBounds_um), {knots_mm});
  return {flat.begin(), flat.end()};
}

}  // namespace

std::vector<double> ReadKnots(const YamlValue& list) {
  std::vector<double> knots;
  for (const YamlValue& knot : list.List()) {
    knots.push_back(knot.Number());
    if (knots.size() > 1 && knots.back() <= knots[knots.size() - 2]) {
      knot.Fail("is not larger than the knot before it",
                "list knots in ascending order");
    }
  }
  if (knots.empty()) {
    list.Fail("needs at least one knot");
    knots.push_back(0);
  }
  return knots;
}

Injected NeutralEffect(int effect, std::string_view axis, const Machine& machine) {
  const Effect& declaration = EffectAt(effect);
  Injected injected{.effect = effect, .axis = std::string(axis)};
  injected.values.resize(declaration.parameters.size());
  declaration.neutral(machine, axis, injected.values);
  return injected;
}

std::vector<InjectedSpec> ReadEffects(YamlMap map, const Machine& machine) {
  return ReadEffects(map.Entries(), machine);
}

std::vector<InjectedSpec> ReadEffects(
    const std::vector<std::pair<std::string, YamlValue>>& entries,
    const Machine& machine) {
  std::vector<InjectedSpec> specs;
  for (const auto& [key, value] : entries) {
    InjectedSpec spec{.place = value.place()};
    if (!ReadName(key, value, machine.kind, &spec)) continue;
    // Any two wirings of three motors share one.
    const bool is_swapped_before = std::ranges::any_of(specs, [&](const auto& one) {
      return one.effect == spec.effect && spec.effect == EffectIndex<MotorsSwapped>();
    });
    if (is_swapped_before) {
      value.Fail("shares a motor with another pair that is swapped",
                 "a motor is plugged into one driver: name one pair, or a ring of all "
                 "three (z1z2z3, z1z3z2)");
      continue;
    }
    const Effect& effect = EffectAt(spec.effect);
    const Injected neutral = NeutralEffect(spec.effect, spec.axis, machine);
    YamlMap parameters = value.Map();
    if (spec.effect == EffectIndex<PitchMap>()) {
      spec.values = ReadTable(&parameters);
      parameters.NoMoreKeys();
      specs.push_back(std::move(spec));
      continue;
    }
    for (std::size_t i = 0; i < effect.parameters.size(); ++i) {
      const Parameter& parameter = effect.parameters[i];
      const auto number = parameters.Optional(std::string(parameter.name));
      spec.values.push_back(
          number ? number->NumberOrDistribution({parameter.min, parameter.max},
                                                parameter.doc)
                 : Distribution(parameter.if_named.value_or(neutral.values[i])));
    }
    parameters.NoMoreKeys();
    specs.push_back(std::move(spec));
  }
  return specs;
}

void RefuseUnknownArtefacts(const std::vector<InjectedSpec>& specs,
                            const std::vector<std::string>& ids,
                            Faults* faults) {
  for (const InjectedSpec& spec : specs) {
    const Effect& effect = EffectAt(spec.effect);
    const bool names_one =
        !spec.axis.empty() &&
        std::ranges::find(effect.axes, kAnyAxis) != effect.axes.end();
    if (!names_one || std::ranges::find(ids, spec.axis) != ids.end()) continue;
    faults->Add(spec.place,
                fmt::format("{}.{} names no artefact: there is no '{}'",
                            effect.name,
                            spec.axis,
                            spec.axis),
                ids.empty() ? "this has no artefacts"
                            : fmt::format("there are {}", fmt::join(ids, ", ")));
  }
}

std::vector<Injected> DrawEffects(const std::vector<InjectedSpec>& specs,
                                  std::uint64_t seed,
                                  std::uint64_t sample) {
  std::vector<Injected> effects;
  for (const InjectedSpec& spec : specs) {
    Injected injected{.effect = spec.effect, .axis = spec.axis};
    const auto parameters = EffectAt(spec.effect).parameters;
    for (std::size_t i = 0; i < spec.values.size(); ++i) {
      // A table has more values than its effect declares: all of them plain numbers.
      if (spec.values.size() > parameters.size()) {
        injected.values.push_back(Middle(spec.values[i]));
        continue;
      }
      Rng rng(
          seed,
          sample,
          fmt::format(
              "{}.{}.{}", EffectAt(spec.effect).name, spec.axis, parameters[i].name));
      injected.values.push_back(
          std::clamp(Draw(spec.values[i], &rng), parameters[i].min, parameters[i].max));
    }
    effects.push_back(std::move(injected));
  }
  return effects;
}

std::string ParameterName(int effect, std::string_view axis, std::size_t parameter) {
  const Effect& declaration = EffectAt(effect);
  std::string name(declaration.name);
  if (!axis.empty()) name += fmt::format(".{}", axis);
  if (declaration.parameters.size() > 1) {
    name += fmt::format(".{}", declaration.parameters[parameter].name);
  }
  return name;
}

double BuiltValue(const Machine& machine,
                  const std::vector<Injected>& effects,
                  int effect,
                  std::string_view axis,
                  std::size_t parameter) {
  double value = NeutralEffect(effect, axis, machine).values[parameter];
  if (EffectAt(effect).name == ProbePretravel::kDeclaration.name) {
    const int i = Index(AxisNamed(axis.substr(0, 1)).value());
    const auto both = ErrorsAt<double>(machine, At{}, effects).pretravel_mm[i];
    if (axis.ends_with('+')) return both[0];
    if (axis.ends_with('-')) return both[1];
    return (both[0] + both[1]) / 2;
  }
  for (const Injected& injected : effects) {
    if (injected.effect == effect && injected.axis == axis)
      value = injected.values[parameter];
  }
  return value;
}

}  // namespace caltwin
